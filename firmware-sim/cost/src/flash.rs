//! Flash by symbol: the largest functions of a program, and sums over the modules of the core.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use object::{Object, ObjectSymbol, SymbolKind};

/// Smallest module of the core with a row of its own, bytes.
const SMALLEST: u64 = 1000;

/// Number of functions that are printed.
const LARGEST: usize = 30;

/// The functions of a build, by name, with their sizes in bytes. Instances of one name are summed.
pub(crate) struct Functions {
    /// The `opt-level` of the build.
    pub(crate) opt: &'static str,
    sizes: BTreeMap<String, u64>,
}

impl Functions {
    /// Reads the symbols of a program.
    pub(crate) fn of(program: &Path, opt: &'static str) -> Result<Self> {
        Self::parse(&fs::read(program)?, opt).with_context(|| program.display().to_string())
    }

    fn parse(program: &[u8], opt: &'static str) -> Result<Self> {
        let file = object::File::parse(program)?;
        let code = file.symbols().filter(|s| s.kind() == SymbolKind::Text && s.size() > 0);
        // One function may have several names.
        let by_address: BTreeMap<_, _> = code.map(|s| (s.address(), s)).collect();
        let symbols = by_address.values().map(|s| Ok((s.name()?, s.size())));
        Ok(Self::new(opt, symbols.collect::<object::Result<Vec<_>>>()?))
    }

    fn new<'a>(opt: &'static str, symbols: impl IntoIterator<Item = (&'a str, u64)>) -> Self {
        let mut sizes = BTreeMap::new();
        for (name, size) in symbols {
            *sizes.entry(format!("{:#}", rustc_demangle::demangle(name))).or_default() += size;
        }
        Self { opt, sizes }
    }

    /// Bytes of each module of the core, by name. Small modules are left out.
    pub(crate) fn modules(&self) -> BTreeMap<&str, u64> {
        let mut sums = BTreeMap::new();
        for (name, size) in &self.sizes {
            if let Some(module) = module(name) {
                *sums.entry(module).or_default() += size;
            }
        }
        sums.retain(|_, bytes| *bytes >= SMALLEST);
        sums
    }
}

/// The module of a function of the core.
fn module(name: &str) -> Option<&str> {
    let mut path = name.split("::");
    let is_core = path.next()?.ends_with("stereo_selfcal");
    let module = path.next()?;
    path.next().filter(|_| is_core && !module.contains(char::is_uppercase)).map(|_| module)
}

/// The largest functions of the core, by the first build, as a table with a column for each build.
pub(crate) fn largest(builds: &[Functions]) -> String {
    let Some(first) = builds.first() else { return String::new() };
    let of_core = first.sizes.iter().filter(|(name, _)| module(name).is_some());
    let mut names: Vec<_> = of_core.collect();
    names.sort_by_key(|&(_, size)| std::cmp::Reverse(size));
    let heads: Vec<_> = builds.iter().map(|build| ["opt ", build.opt].concat()).collect();
    let (heads, line) = (heads.join(" | "), "--:|".repeat(builds.len()));
    let mut text = format!("| largest functions, bytes | {heads} |\n|---|{line}\n");
    for (name, _) in names.into_iter().take(LARGEST) {
        let cell = |build: &Functions| build.sizes.get(name).map(u64::to_string);
        // A function without a size is inlined.
        let cells: Vec<_> = builds.iter().map(|build| cell(build).unwrap_or_default()).collect();
        let name = name.replace("stereo_selfcal::", "");
        text += &["| ", &name, " | ", &cells.join(" | "), " |\n"].concat();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: &str = "<stereo_selfcal::pair::solver::PairSolver<f32>>::step";
    /// The same function, mangled.
    const MANGLED: &str = "_RNvMNtNtCs1234_14stereo_selfcal4pair6solverINtB2_10PairSolverfE4step";

    const INVERT: &str = "stereo_selfcal::fusion::lens::invert::<f32>";

    fn made() -> [Functions; 2] {
        let others = [
            ("<stereo_selfcal::fusion::Fusion<f32>>::propose", 700),
            (INVERT, 3000),
            ("<cost::probe::Probe>::run::<stereo_selfcal::batch::Pushed>", 500),
            ("memcpy", 3),
        ];
        let fast = others.into_iter().chain([(MANGLED, 1000), (MANGLED, 200)]);
        [Functions::new("3", fast), Functions::new("s", [(STEP, 900)])]
    }

    #[test]
    fn modules_of_the_core_are_summed_over_their_functions() {
        let [fast, small] = made();
        assert_eq!(fast.modules(), BTreeMap::from([("fusion", 3700), ("pair", 1200)]));
        assert_eq!(small.modules(), BTreeMap::new());
        assert_eq!(module("<f32 as stereo_selfcal::scalar::Scalar>::lit"), Some("scalar"));
        assert_eq!(module("stereo_selfcal::Root::new"), None);
    }

    #[test]
    fn the_largest_functions_of_the_core_are_listed_side_by_side() {
        let text = largest(&made());
        let rows: Vec<_> = text.lines().skip(2).collect();
        assert_eq!(rows[0], "| fusion::lens::invert::<f32> | 3000 |  |");
        assert_eq!(rows[1], "| <pair::solver::PairSolver<f32>>::step | 1200 | 900 |");
        assert_eq!(rows.len(), 3);
    }

    #[test]
    fn bytes_of_no_program_are_refused() {
        assert!(Functions::parse(b"no program", "3").is_err());
    }
}
