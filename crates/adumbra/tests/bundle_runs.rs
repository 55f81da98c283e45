//! The byte ranges that a camera requests from a server for the pages around it: `docs/guides/farms.md`,
//! "What a world costs".

use adumbra::layout::depths::page::bundles;

/// Bundles along a side of the grid.
const SIDE: u32 = 64;
const RADIUS_BUNDLES: f64 = 5.0;

#[test]
fn disc_of_bundles_is_a_few_contiguous_runs() {
    // A bundle is 4 x 4 pages.
    let order = bundles([4 * SIDE, 4 * SIDE]);
    assert_eq!(order.len(), (SIDE * SIDE) as usize);
    let (mut discs, mut inside, mut runs) = (0_u32, 0_u32, 0_u32);
    for step in 0..40 * 40_u32 {
        // Anywhere within a bundle.
        let centre = [step % 40, step / 40].map(|n| 12.0 + 0.975 * f64::from(n));
        // The disc meets the circle around a bundle.
        let wanted = |at: &[u32; 2]| {
            let [x, y] = [0, 1].map(|a| f64::from(at[a]) + 0.5 - centre[a]);
            x.hypot(y) <= RADIUS_BUNDLES + 0.5_f64.sqrt()
        };
        discs += 1;
        inside += order.iter().filter(|at| wanted(at)).count() as u32;
        runs += order.chunk_by(|a, b| wanted(a) == wanted(b)).filter(|run| wanted(&run[0])).count() as u32;
    }
    let [bundles, runs] = [inside, runs].map(|n| f64::from(n) / f64::from(discs));
    println!("{bundles:.1} bundles in {runs:.1} runs");
    assert!((bundles - 102.3).abs() < 0.1 && (runs - 11.4).abs() < 0.1, "{bundles} bundles in {runs} runs");
}
