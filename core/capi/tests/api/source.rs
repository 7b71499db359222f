//! Enumerations and functions as the sources declare them, so that the tests notice a new one.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use syn::{Expr, FnArg, Item, ItemEnum, Lit, Type};

fn files(dir: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path());
    let (dirs, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    let sources = files.into_iter().filter(|path| path.extension().is_some_and(|e| e == "rs"));
    sources.chain(dirs.iter().flat_map(|dir| self::files(dir))).collect()
}

fn items(of: &str) -> Vec<Item> {
    let sources = files(&Path::new(env!("CARGO_MANIFEST_DIR")).join(of));
    let parse = |path: PathBuf| syn::parse_file(&fs::read_to_string(path).unwrap()).unwrap().items;
    sources.into_iter().flat_map(parse).collect()
}

/// The variants of every enum, with their numbers if they have explicit ones.
type Enums = BTreeMap<String, Vec<(String, Option<i64>)>>;

/// Enums of the core, parsed once.
static CORE: LazyLock<Enums> = LazyLock::new(|| enums("../src"));

/// Enums of the C API, parsed once.
static C: LazyLock<Enums> = LazyLock::new(|| enums("src"));

fn enums(of: &str) -> Enums {
    let number = |expression: &Expr| match expression {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Int(number) => number.base10_parse().ok(),
            _ => None,
        },
        _ => None,
    };
    let all = items(of).into_iter().filter_map(|item| match item {
        Item::Enum(item) => Some(item),
        Item::Macro(item) if item.mac.path.is_ident("c_enum") => {
            Some(item.mac.parse_body::<ItemEnum>().unwrap())
        }
        _ => None,
    });
    all.map(|item| {
        let variants = item
            .variants
            .iter()
            .map(|v| (v.ident.to_string(), v.discriminant.as_ref().and_then(|(_, e)| number(e))));
        (item.ident.to_string(), variants.collect())
    })
    .collect()
}

/// Names of the variants of an enum of the core.
pub(crate) fn variants_of_core(name: &str) -> BTreeSet<String> {
    let variants = CORE.get(name).unwrap_or_else(|| panic!("no enum {name}"));
    variants.iter().map(|(name, _)| name.clone()).collect()
}

/// Variants of an enum of C, with their numbers.
pub(crate) fn variants_of_c(name: &str) -> Vec<(String, i64)> {
    let variants = C.get(name).unwrap_or_else(|| panic!("no enum {name}"));
    variants.iter().map(|(name, number)| (name.clone(), number.expect("a number"))).collect()
}

/// Functions whose first argument is an initialised storage of this type.
pub(crate) fn functions_of(storage: &str) -> BTreeSet<String> {
    let takes_one = |argument: Option<&FnArg>| match argument {
        Some(FnArg::Typed(argument)) => match &*argument.ty {
            Type::Ptr(pointer) => match &*pointer.elem {
                Type::Path(path) => path.path.is_ident(storage),
                _ => false,
            },
            _ => false,
        },
        _ => false,
    };
    let functions = items("src").into_iter().filter_map(|item| match item {
        Item::Fn(item) if item.sig.abi.is_some() && takes_one(item.sig.inputs.first()) => {
            Some(item.sig.ident.to_string())
        }
        _ => None,
    });
    functions.filter(|name| !name.ends_with("_init")).collect()
}
