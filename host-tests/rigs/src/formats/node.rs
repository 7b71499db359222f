//! A file of any syntax as a tree, and its values with their paths: an error names file, key and value.

use std::fmt;

use anyhow::{Context, Error, Result, anyhow, ensure};
use nalgebra::{Matrix3, Vector3};
use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};

use super::rigid::Rigid;
use crate::data::Rows;

/// Characters of a value that an error shows.
const SHOWN: usize = 60;

/// Largest deviation of the last row of a transform from `0 0 0 1`.
const ROUNDING: f64 = 1e-9;

/// A value of YAML, JSON, XML or a text of names and numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Node {
    Null,
    Bool(bool),
    Number(f64),
    Text(String),
    List(Vec<Node>),
    Map(Vec<(String, Node)>),
}

impl Node {
    /// The value of a key; `a.b` is also the key `b` within `a`.
    pub(super) fn get(&self, key: &str) -> Option<&Self> {
        let Self::Map(all) = self else { return None };
        let find = |key: &str| all.iter().find(|(name, _)| name == key).map(|(_, node)| node);
        find(key).or_else(|| {
            let (outer, inner) = key.split_once('.')?;
            find(outer)?.get(inner)
        })
    }

    /// Whether there is a value at a key, not blank; `a.b` is also the key `b` of the first item of a list `a`.
    fn has(&self, key: &str) -> bool {
        match (self, key.split_once('.')) {
            (Self::List(all), _) => all.first().is_some_and(|first| first.has(key)),
            (Self::Map(all), parts) => all.iter().any(|(name, node)| {
                (name == key && *node != Self::Null)
                    || parts.is_some_and(|(outer, inner)| name == outer && node.has(inner))
            }),
            _ => false,
        }
    }

    /// The content of a text: a number, several numbers, or the text.
    pub(super) fn of_text(text: &str) -> Self {
        let words: Vec<&str> = text.split_whitespace().collect();
        let numbers: Option<Vec<f64>> = words.iter().map(|word| word.parse().ok()).collect();
        match numbers.as_deref() {
            Some([]) => Self::Null,
            Some([one]) => Self::Number(*one),
            Some(several) => Self::List(several.iter().copied().map(Self::Number).collect()),
            None => Self::Text(text.trim().to_owned()),
        }
    }
}

impl fmt::Display for Node {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null => f.write_str("blank"),
            Self::Bool(x) => write!(f, "{x}"),
            Self::Number(x) => write!(f, "{x}"),
            Self::Text(text) => f.write_str(text),
            Self::List(all) => {
                let all: Vec<String> = all.iter().map(ToString::to_string).collect();
                write!(f, "[{}]", all.join(", "))
            }
            Self::Map(all) => {
                let all: Vec<String> =
                    all.iter().map(|(key, node)| format!("{key}: {node}")).collect();
                write!(f, "{{{}}}", all.join(", "))
            }
        }
    }
}

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(AnyNode)
    }
}

struct AnyNode;

impl<'de> Visitor<'de> for AnyNode {
    type Value = Node;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, a text, a list or keys with values")
    }

    fn visit_unit<E>(self) -> Result<Node, E> {
        Ok(Node::Null)
    }

    fn visit_none<E>(self) -> Result<Node, E> {
        Ok(Node::Null)
    }

    fn visit_some<D: Deserializer<'de>>(self, from: D) -> Result<Node, D::Error> {
        Node::deserialize(from)
    }

    fn visit_bool<E>(self, x: bool) -> Result<Node, E> {
        Ok(Node::Bool(x))
    }

    #[expect(clippy::cast_precision_loss, reason = "a number of a rig is below 2^53")]
    fn visit_i64<E>(self, x: i64) -> Result<Node, E> {
        Ok(Node::Number(x as f64))
    }

    #[expect(clippy::cast_precision_loss, reason = "a number of a rig is below 2^53")]
    fn visit_u64<E>(self, x: u64) -> Result<Node, E> {
        Ok(Node::Number(x as f64))
    }

    fn visit_f64<E>(self, x: f64) -> Result<Node, E> {
        Ok(Node::Number(x))
    }

    fn visit_str<E>(self, text: &str) -> Result<Node, E> {
        Ok(Node::Text(text.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut all: A) -> Result<Node, A::Error> {
        let mut list = Vec::new();
        while let Some(node) = all.next_element()? {
            list.push(node);
        }
        Ok(Node::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut all: A) -> Result<Node, A::Error> {
        let mut map = Vec::new();
        while let Some((key, node)) = all.next_entry::<Node, Node>()? {
            map.push((key.to_string(), node));
        }
        Ok(Node::Map(map))
    }
}

/// The number as a count; `None` if it is negative, has a fraction or is above 65535.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is in range")]
fn whole(number: f64) -> Option<u16> {
    let is_whole = number.fract() == 0.0 && (0.0..=f64::from(u16::MAX)).contains(&number);
    is_whole.then_some(number as u16)
}

/// A node and its path: the file, then the keys.
#[derive(Debug, Clone)]
pub(super) struct Value<'a> {
    node: &'a Node,
    place: String,
}

impl<'a> Value<'a> {
    pub(super) fn new(node: &'a Node, place: String) -> Self {
        Self { node, place }
    }

    /// File and keys.
    pub(super) fn place(&self) -> &str {
        &self.place
    }

    /// An error that names file, key and value, and the remedy.
    pub(super) fn refuse(&self, why: impl fmt::Display) -> Error {
        let value = self.node.to_string();
        let cut = value.char_indices().nth(SHOWN).map(|(at, _)| at);
        let value = cut.map_or(value.clone(), |at| format!("{}..", &value[..at]));
        anyhow!("{}: {value}: {why}", self.place)
    }

    fn child(&self, node: &'a Node, key: &str) -> Self {
        // The place leaves out two keys: that of a table, which is the name of its file, and "" of a list at the root.
        let is_whole = key.is_empty() || self.place.ends_with(key) && key.contains('.');
        let place = if is_whole { self.place.clone() } else { format!("{}: {key}", self.place) };
        Self { node, place }
    }

    /// Whether there is a value at a key, as [`Node::has`].
    pub(super) fn has(&self, key: &str) -> bool {
        self.node.has(key)
    }

    /// The value of the first of these keys that exists and is not blank.
    pub(super) fn get(&self, keys: &[&str]) -> Option<Self> {
        let here = |key: &&str| Some(self.child(self.node.get(key)?, key));
        keys.iter().filter_map(here).find(|value| *value.node != Node::Null)
    }

    /// As [`Self::get`], for a required key.
    ///
    /// * `what`: the expected value, for the error.
    pub(super) fn need(&self, keys: &[&str], what: &str) -> Result<Self> {
        self.get(keys).with_context(|| {
            let keys = keys.join(" or ");
            format!("{}: {keys} is missing: expected {what}", self.place)
        })
    }

    /// The number of a required key.
    pub(super) fn number_at(&self, key: &str) -> Result<f64> {
        self.need(&[key], "a number")?.number()
    }

    /// The numbers of required keys.
    pub(super) fn numbers_at<const N: usize>(
        &self,
        keys: [impl AsRef<str>; N],
    ) -> Result<[f64; N]> {
        let mut numbers = [0.0; N];
        for (number, key) in numbers.iter_mut().zip(keys) {
            *number = self.number_at(key.as_ref())?;
        }
        Ok(numbers)
    }

    /// The numbers of keys; 0 for a missing key.
    pub(super) fn numbers_or_0(&self, keys: &[impl AsRef<str>]) -> Result<Vec<f64>> {
        let number = |key: &_| {
            let value = self.get(&[AsRef::<str>::as_ref(key)]);
            value.map_or(Ok(0.0), |value| value.number())
        };
        keys.iter().map(number).collect()
    }

    /// The text of the first of these keys; empty without a value.
    pub(super) fn text_at(&self, keys: &[&str]) -> String {
        self.get(keys).as_ref().map(Self::text).unwrap_or_default()
    }

    /// Width and height of two keys, px.
    pub(super) fn size_at(&self, width: &[&str], height: &[&str]) -> Result<[u16; 2]> {
        Ok([self.need(width, "a width, px")?.count()?, self.need(height, "a height, px")?.count()?])
    }

    /// As [`Self::size_at`]; `None` if one of the keys is missing.
    pub(super) fn size_if(&self, width: &[&str], height: &[&str]) -> Result<Option<[u16; 2]>> {
        let both = self.get(width).is_some() && self.get(height).is_some();
        both.then(|| self.size_at(width, height)).transpose()
    }

    /// The camera of this number in a list.
    pub(super) fn camera(&self, n: u8) -> Result<Self> {
        let all = self.items();
        let count = all.len();
        all.into_iter().nth(n.into()).with_context(|| {
            let place = &self.place;
            format!("{place}: {count} cameras, there is no number {n}: choose the left and the right one (--cameras)")
        })
    }

    /// The values of a list; empty for other nodes.
    pub(super) fn items(&self) -> Vec<Self> {
        let Node::List(all) = self.node else { return Vec::new() };
        (0..).zip(all).map(|(i, node): (usize, _)| self.child(node, &format!("[{i}]"))).collect()
    }

    /// The keys of a map; empty for other nodes.
    pub(super) fn keys(&self) -> Vec<&'a str> {
        let Node::Map(all) = self.node else { return Vec::new() };
        all.iter().map(|(key, _)| key.as_str()).collect()
    }

    /// All values with keys, also those within others, each with its keys from the outermost to its own. A matrix with
    /// its shape is one value.
    pub(super) fn nested(&self) -> Vec<(Vec<&'a str>, Self)> {
        let Node::Map(all) = self.node else { return Vec::new() };
        if self.get(&["data"]).is_some() {
            return Vec::new();
        }
        let mut found = Vec::new();
        for (key, node) in all {
            let value = self.child(node, key);
            let within = value.nested();
            found.push((vec![key.as_str()], value));
            found.extend(
                within.into_iter().map(|(keys, value)| {
                    (std::iter::once(key.as_str()).chain(keys).collect(), value)
                }),
            );
        }
        found
    }

    /// Whether the value is a list of numbers.
    pub(super) fn is_matrix(&self) -> bool {
        let is_list = matches!(self.node, Node::List(_)) || self.get(&["data"]).is_some();
        is_list && self.numbers().is_ok_and(|numbers| numbers.len() > 2)
    }

    /// The value as text; empty if it is blank.
    pub(super) fn text(&self) -> String {
        if *self.node == Node::Null { String::new() } else { self.node.to_string() }
    }

    pub(super) fn number(&self) -> Result<f64> {
        let number = match self.node {
            Node::Number(x) => Some(*x),
            Node::Text(text) => text.trim().parse().ok(),
            _ => None,
        };
        let finite = number.filter(|x: &f64| x.is_finite());
        finite.ok_or_else(|| self.refuse("expected a finite number"))
    }

    /// A number of pixels, or any other count.
    pub(super) fn count(&self) -> Result<u16> {
        whole(self.number()?).ok_or_else(|| self.refuse("expected a whole number from 0 to 65535"))
    }

    /// Width and height, px.
    pub(super) fn size(&self) -> Result<[u16; 2]> {
        let [width, height] = self.array("width and height")?;
        let both = whole(width).zip(whole(height)).map(<[u16; 2]>::from);
        both.ok_or_else(|| self.refuse("expected width and height, whole numbers from 0 to 65535"))
    }

    /// All numbers, row by row: of a matrix with `rows`, `cols` and `data`, of nested lists, or of a text.
    pub(super) fn numbers(&self) -> Result<Vec<f64>> {
        let data = self.get(&["data"]);
        let mut numbers = Vec::new();
        data.as_ref().unwrap_or(self).collect(&mut numbers)?;
        if let Some((rows, cols)) = self.shape()? {
            let count = usize::from(rows) * usize::from(cols);
            let len = numbers.len();
            ensure!(count == len, self.refuse(format!("{len} numbers: expected {rows} x {cols}")));
        }
        Ok(numbers)
    }

    fn shape(&self) -> Result<Option<(u16, u16)>> {
        match (self.get(&["rows"]), self.get(&["cols"])) {
            (Some(rows), Some(cols)) => Ok(Some((rows.count()?, cols.count()?))),
            _ => Ok(None),
        }
    }

    fn collect(&self, into: &mut Vec<f64>) -> Result<()> {
        match self.node {
            Node::List(_) => self.items().iter().try_for_each(|item| item.collect(into)),
            Node::Text(text) => {
                let parts = text.split(|c: char| c.is_whitespace() || "[](),;".contains(c));
                for word in parts.filter(|word| !word.is_empty()) {
                    let number = word.parse().ok().filter(|x: &f64| x.is_finite());
                    into.push(number.ok_or_else(|| self.refuse("expected finite numbers"))?);
                }
                Ok(())
            }
            Node::Null => Ok(()),
            _ => {
                into.push(self.number()?);
                Ok(())
            }
        }
    }

    /// Exactly `N` numbers. `what` names them in errors.
    pub(super) fn array<const N: usize>(&self, what: &str) -> Result<[f64; N]> {
        let numbers = self.numbers()?;
        let len = numbers.len();
        numbers
            .try_into()
            .map_err(|_| self.refuse(format!("{len} numbers: expected {what} ({N} numbers)")))
    }

    /// Numbers in `rows` rows and `cols` columns, `N` in all.
    pub(super) fn shaped<const N: usize>(&self, rows: u16, cols: u16) -> Result<[f64; N]> {
        let shape = self.shape()?;
        let fits = shape.is_none_or(|said| said == (rows, cols));
        ensure!(fits, self.refuse(format!("expected {rows} x {cols} numbers")));
        self.array(&format!("a matrix of {rows} x {cols}"))
    }

    /// 3 x 3 numbers.
    pub(super) fn square(&self) -> Result<Rows> {
        let [a, b, c, d, e, f, g, h, i] = self.shaped(3, 3)?;
        Ok([[a, b, c], [d, e, f], [g, h, i]])
    }

    /// `[R t; 0 1]`, or `[R t]` with `rows: 3` and `cols: 4`. An error if `R` is not a rotation.
    pub(super) fn transform(&self) -> Result<Rigid> {
        let numbers = self.numbers()?;
        let (rows, last) = numbers.split_at(numbers.len().min(12));
        let homogeneous =
            last.iter().zip([0.0, 0.0, 0.0, 1.0]).all(|(a, b)| (a - b).abs() < ROUNDING);
        let three = self.shape()? == Some((3, 4));
        let whole = rows.len() == 12 && (last.len() == 4 || three) && homogeneous;
        let wanted = "expected a transform of 4 x 4 numbers with the last row 0 0 0 1";
        ensure!(whole, self.refuse(wanted));
        let at = |i: usize, j: usize| rows[4 * i + j];
        let rigid = Rigid { r: Matrix3::from_fn(at), t: Vector3::from_fn(|i, _| at(i, 3)) };
        rigid.check().map_err(|why| self.refuse(why))?;
        Ok(rigid)
    }
}
