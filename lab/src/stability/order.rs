//! The same hits in other orders: how many different bodies come out.

use std::collections::HashSet;

use anyhow::Result;
use crumple::Hit;

use super::{Dice, Method, apart, hash, random_hit, shots};
use crate::Options;
use crate::metric::{deepest, median};
use crate::table::{Table, num};
use crate::truth::Truth;

pub fn run(options: &Options) -> Result<()> {
    let (scenes, orders) = if options.quick { (1, 24) } else { (3, 60) };
    let columns =
        ["body", "method", "hits", "orders", "results_median", "results_worst", "apart_median", "apart_worst", "n"];
    let mut table = Table::new(&columns);
    table.comment("what", "random hits in one place of the body, folded one by one, in different orders");
    table.comment("results", "different results, by a hash of every bit of the positions");
    table.comment("apart", "largest distance of a vertex between two results over the deepest dent");
    for name in Truth::SMOOTH_BODIES {
        let (_, set) = shots(name)?;
        for method in Method::ALL {
            for count in 2..=8 {
                let mut results = Vec::new();
                let mut aparts = Vec::new();
                let mut tried = 0;
                for scene in 0..scenes {
                    let mut dice = Dice::new(100 * scene + count as u64);
                    let hits: Vec<Hit> = (0..count)
                        .map(|_| {
                            let share = dice.between(0.05, 0.6);
                            random_hit(&set, &mut dice, share)
                        })
                        .collect();
                    let orders = permutations(count, orders, &mut dice);
                    tried = orders.len();
                    let mut hashes = HashSet::new();
                    let first = method.after(&set, &hits)?;
                    let mut furthest = 0.0f64;
                    for order in orders {
                        let hits: Vec<Hit> = order.iter().map(|i| hits[*i]).collect();
                        let field = method.after(&set, &hits)?;
                        hashes.insert(hash(&field));
                        furthest = furthest.max(apart(&field, &first));
                    }
                    results.push(hashes.len() as f64);
                    aparts.push(furthest / deepest(&first));
                }
                let worst = |v: &[f64]| v.iter().copied().fold(0.0, f64::max);
                table.row([
                    name.to_owned(),
                    method.name().to_owned(),
                    count.to_string(),
                    tried.to_string(),
                    num(median(&results)),
                    num(worst(&results)),
                    num(median(&aparts)),
                    num(worst(&aparts)),
                    scenes.to_string(),
                ])?;
            }
        }
    }
    table.write(&options.out, "stability_order.csv").map(drop)
}

/// All orders of `n` things where there are no more than `most`, else that many different ones at random.
fn permutations(n: usize, most: usize, dice: &mut Dice) -> Vec<Vec<usize>> {
    let all: usize = (1..=n).product();
    let mut seen = HashSet::new();
    let mut found = Vec::new();
    let mut order: Vec<usize> = (0..n).collect();
    while found.len() < all.min(most) {
        if seen.insert(order.clone()) {
            found.push(order.clone());
        }
        dice.shuffle(&mut order);
    }
    found
}
