//! `evidence campaign real`.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result, ensure};
use sim::run::progress;
use sim::run::real_figures::Figures;
use sim::run::real_rigs::runs;

use super::CampaignArgs;
use super::real_cases::{Case, all};

/// Meaning of the columns.
const LEGEND: &str = "\
mrad. e_t, e_R: error of the estimate at the end, median and worst of the runs. fit: joint fit of all true
matches, RMS; x fit: RMS error over it (meaningless where disparities drown in noise: there bound, Cramer-Rao, counts;
meaningless too where landmarks keep their errors).
sd: reported, median. /sd: error over it, 95 % and worst. NEES: over its 5 degrees of freedom, 1 if consistent.
lock: runs locked at the end, ever. armed: % of runs after 10 pairs, 50, the last. bad: runs with a locked pair
beyond 5 sd; >5sd: % of locked pairs so, of armed pairs. use: e_t in use, median and worst; x start: its worst
over that of R = I, t = (-1, 0, 0); px: RMS row offset in use by the health, before the last pair was applied.";

const HEADING: &str = "\
case                   pairs        e_t         e_R    fit t,R     x fit t,R   bound t       sd t,R       t/sd       \
R/sd  NEES   lock       armed   bad      >5sd        use t  x start     px";

impl CampaignArgs {
    pub(super) fn real(&self) -> Result<()> {
        let chosen = |case: &Case| {
            let path = case.path();
            self.takes(&path)
        };
        let cases: Vec<Case> = all()?.into_iter().filter(chosen).collect();
        ensure!(!cases.is_empty(), "no case begins with {}", self.only.join(" or "));
        let mut table = self.csv.as_deref().map(CsvTable::create).transpose()?;
        let mut out = io::stdout();
        writeln!(out, "{LEGEND}\n{HEADING}")?;
        let bar = progress::over(cases.len() * usize::try_from(self.trials())?, "runs");
        let mut group = "";
        for mut case in cases {
            case.scenario.pairs = self.pairs.unwrap_or(case.scenario.pairs);
            bar.set_message(format!("runs, {}", case.path()));
            let runs = runs::<f32>(&case.scenario, self.lens.config(), self.seeds(), || bar.inc(1))
                .with_context(|| case.path())?;
            let all = case.scenario.pairs;
            let parts = case.also_after.iter().copied().filter(|&pairs| pairs < all);
            for pairs in parts.chain([all]) {
                let figures = Figures::after(&runs, pairs);
                bar.suspend(|| {
                    if group != case.group {
                        writeln!(out, "{}", case.group)?;
                    }
                    writeln!(out, "  {}", line(&case.name, &figures))
                })?;
                group = case.group;
                if let Some(table) = &mut table {
                    table.add(&case, &figures)?;
                }
            }
        }
        bar.finish_and_clear();
        Ok(())
    }
}

/// Figures of a case, after each number of pairs that is reported.
///
/// # Errors
/// If there is no such case, or its scene cannot be seen.
pub(super) fn figures(args: &CampaignArgs, path: &str) -> Result<Vec<Figures>> {
    let case = all()?.into_iter().find(|case| case.path() == path);
    let Case { scenario, also_after, .. } = case.with_context(|| format!("no case {path}"))?;
    let bar = progress::over(usize::try_from(args.trials())?, "runs");
    let runs = runs::<f32>(&scenario, args.lens.config(), args.seeds(), || bar.inc(1))?;
    bar.finish_and_clear();
    let pairs = also_after.into_iter().chain([scenario.pairs]);
    Ok(pairs.map(|pairs| Figures::after(&runs, pairs)).collect())
}

/// One row of the table.
fn line(name: &str, figures: &Figures) -> String {
    let Figures { rms: _, joint_fit, bound, sd, locked, armed, beyond, .. } = figures;
    let two = |[a, b]: [f64; 2], unit: f64| format!("{}/{}", short(a * unit), short(b * unit));
    let percent =
        |share: f64| if share.is_nan() { "-".into() } else { format!("{:.0}", 100.0 * share) };
    let [at_10, at_50, at_end] = armed.map(percent);
    let beyond = beyond.map(|share| short(100.0 * share));
    format!(
        "{name:<21} {:>4} {:>11} {:>11} {:>10} {:>11} {:>9} {:>12} {:>10} {:>10} {:>5} {:>6} {:>11} \
         {:>5} {:>9} {:>12} {:>8} {:>6}",
        figures.pairs,
        two(figures.e_t, 1e3),
        two(figures.e_r, 1e3),
        two([joint_fit.translation, joint_fit.rotation], 1e3),
        two(figures.over_joint_fit(), 1.0),
        short(bound.translation * 1e3),
        two([sd.translation, sd.rotation], 1e3),
        two(figures.t_in_sd, 1.0),
        two(figures.r_in_sd, 1.0),
        short(figures.nees),
        format!("{}/{}", locked[0], locked[1]),
        format!("{at_10}/{at_50}/{at_end}"),
        figures.bad,
        beyond.join("/"),
        two(figures.in_use_t, 1e3),
        short(figures.in_use_growth),
        short(figures.in_use_px),
    )
}

/// A few significant digits: whole numbers from 100 on, three digits from 0.1 on, four decimals below, one digit below
/// 0.001.
fn short(number: f64) -> String {
    match number.abs() {
        size if size.is_nan() => "-".into(),
        0.0 => "0".into(),
        size if size < 9.995e-4 => format!("{number:.0e}"),
        size if size < 0.09995 => format!("{number:.4}"),
        size if size < 0.9995 => format!("{number:.3}"),
        size if size < 9.995 => format!("{number:.2}"),
        size if size < 99.95 => format!("{number:.1}"),
        _ => format!("{number:.0}"),
    }
}

/// The file of `--csv`. At any time it is complete up to the last case.
struct CsvTable {
    writer: csv::Writer<File>,
    headed: bool,
}

impl CsvTable {
    fn create(path: &Path) -> Result<Self> {
        let writer = csv::Writer::from_path(path)
            .with_context(|| format!("cannot write {}", path.display()))?;
        Ok(Self { writer, headed: false })
    }

    fn add(&mut self, case: &Case, figures: &Figures) -> Result<()> {
        let columns = figures.columns();
        if !self.headed {
            let names = columns.iter().map(|(name, _)| *name);
            self.writer.write_record(["group", "case"].into_iter().chain(names))?;
            self.headed = true;
        }
        let numbers = columns.iter().map(|(_, number)| number.to_string());
        let names = [case.group.to_owned(), case.name.clone()];
        self.writer.write_record(names.into_iter().chain(numbers))?;
        Ok(self.writer.flush()?)
    }
}
