//! Cost of a pair: host time and instructions, beside a general least-squares solver.
//!
//! ```sh
//! cargo bench -p selfcal-evidence --bench cost
//! ```
//!
//! Scene `near` (3 to 80 baselines), 0.3 px of noise, `R` off by 5 degrees about each axis and `t` by 5 degrees. All
//! methods solve the same pairs from `R = I`, `t = (-1, 0, 0)`. The calibrator computes in `f32`:
//! - `robust, acquiring`: `solve_pair` of a fresh calibrator;
//! - `robust, one pass`: a late pass of such a search, with its step;
//! - `robust, locked`: `solve_pair` of a calibrator locked on earlier pairs;
//! - `paper`: `solve_pair` of a fresh calibrator;
//! - `lmder`: the crate `levenberg-marquardt` on the paper's row offsets, see [`minpack`].
//!
//! Columns, over the same [`case::PAIRS`] generated pairs:
//! - `wrong`: share of outliers;
//! - `us`: median time of a pair on this host, caches warm;
//! - `instr`: mean instructions of a pair, counted by valgrind's callgrind in a run of its own,
//!   without generating the scene and filling the batch; `-` without valgrind. The same build gives
//!   the same count. They are this host's: a controller's differ;
//! - `instr/match/pass`: the same over matches and passes; `-` unless all pairs were solved;
//! - `passes`: mean passes over the batch, evaluations included. For `lmder`, evaluations of the
//!   residuals; its Jacobians and QR factorisations are in the instructions;
//! - `solved`: pairs with an answer; for `lmder`, pairs within its tolerances;
//! - `sigma_t`, `sigma_theta`: RMS error of the solved single pairs, rad.
//!
//! A harness of its own, because no usual one both times and counts: those that count need a runner
//! or valgrind's headers.

mod callgrind;
mod case;
mod minpack;

use std::hint::black_box;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use clap::Parser;
use host_tests::stats::median;
use stereo_selfcal::geometry::metrics::Deviation;

use callgrind::Count;
use case::{Answer, Case, Job};

/// Runs of each pair that are timed.
const RUNS: usize = 20;

#[derive(Parser)]
struct Args {
    /// Passed by cargo.
    #[arg(long, hide = true)]
    bench: bool,
    /// Run each pair of this row once only, for callgrind to count.
    #[arg(long, hide = true)]
    row: Option<usize>,
}

/// Results of the pairs of a row.
struct Results {
    pairs: usize,
    /// Sum of the passes of the solved pairs.
    passes: usize,
    /// Jobs with an answer.
    solved: usize,
    /// Error of each pair that was solved to the end.
    errors: Vec<Deviation<f64>>,
}

impl Results {
    fn of(case: &Case, answers: &[Answer]) -> Self {
        let solved = answers.iter().filter_map(|answer| case.outcome(answer).ok());
        let (passes, errors): (Vec<usize>, Vec<_>) = solved.unzip();
        let (solved, passes) = (passes.len(), passes.iter().sum());
        let errors = errors.into_iter().flatten().collect();
        Self { pairs: answers.len(), passes, solved, errors }
    }
}

fn main() -> Result<()> {
    let args = Args::parse();
    if let Some(row) = args.row {
        let case = Case::all().nth(row).context("no such row")?;
        let answers = callgrind::run_once(case.jobs()?, Job::run)?;
        println!("{}", Results::of(&case, &answers).passes);
        return Ok(());
    }
    let counts = callgrind::is_present();
    if !counts {
        println!("valgrind was not found: no instruction counts\n");
    }
    println!(
        "|    N | wrong | method            |    us |    instr | instr/match/pass | passes | solved \
         | sigma_t | sigma_theta |"
    );
    println!("|--:|--:|---|--:|--:|--:|--:|--:|--:|--:|");
    for (row, case) in Case::all().enumerate() {
        let (answers, us) = timed(&case.jobs()?);
        let results = Results::of(&case, &answers);
        let count = counts.then(|| callgrind::count(row)).transpose()?;
        let passes = results.passes.to_string();
        let same = count.as_ref().is_none_or(|count| count.said == passes);
        ensure!(same, "the counted run took other passes than the timed one: {case:?}");
        print_row(&case, us, count.as_ref(), &results);
    }
    Ok(())
}

/// The answer to each job, and the median time of one, us.
fn timed(jobs: &[Job]) -> (Vec<Answer>, f64) {
    let mut times = Vec::with_capacity(jobs.len() * RUNS);
    let mut run = |job: &Job| {
        let job = job.clone();
        let start = Instant::now();
        let answer = black_box(job.run());
        times.push(start.elapsed().as_secs_f64() * 1e6);
        answer
    };
    let answers = jobs.iter().map(&mut run).collect();
    for _ in 1..RUNS {
        for job in jobs {
            run(job);
        }
    }
    (answers, median(times).unwrap_or(f64::NAN))
}

fn print_row(case: &Case, us: f64, count: Option<&Count>, results: &Results) {
    let [matches, pairs, passes] = [case.matches, results.pairs, results.passes].map(as_f64);
    let solved = results.solved;
    let sigma = Deviation::root_mean_square(results.errors.iter().copied());
    let sigma = |part: fn(&Deviation<f64>) -> f64| {
        sigma.as_ref().map_or("-".into(), |sigma| format!("{:.5}", part(sigma)))
    };
    let instructions = count.map_or("-".into(), |c| format!("{:.0}", c.instructions / pairs));
    // The number of passes of a pair without an answer is unknown.
    let per_pass = count.filter(|_| solved == results.pairs);
    let per_pass =
        per_pass.map_or("-".into(), |c| format!("{:.0}", c.instructions / (passes * matches)));
    println!(
        "| {:4} | {:3.0} % | {:17} | {us:5.0} | {instructions:>8} | {per_pass:>16} | {:6.1} | {:>6} \
         | {:>7} | {:>11} |",
        case.matches,
        case.outliers * 100.0,
        case.method.to_string(),
        passes / as_f64(solved),
        format!("{solved}/{}", results.pairs),
        sigma(|sigma| sigma.translation),
        sigma(|sigma| sigma.rotation),
    );
}

fn as_f64(n: usize) -> f64 {
    u32::try_from(n).map_or(f64::INFINITY, f64::from)
}
