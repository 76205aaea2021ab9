//! A model reduced to the sums that its likelihood needs: cross-products per group, with those of
//! groups with the same design added up.
//!
//! Groups are independent, so everything is a sum over groups of products of Zᵢᵀ Zᵢ, Zᵢᵀ Xᵢ, Xᵢᵀ Xᵢ
//! and of Zᵢᵀ yᵢ, Xᵢᵀ yᵢ, yᵢᵀ yᵢ. The first three are the same for all participants who did the
//! same trials: a thousand people on one design share one factorisation.
//!
//! Before that, X = Q R is orthonormalised and y is replaced by its least-squares residuals, so a
//! large mean costs no digits; the random columns are divided by their root mean squares.

use super::model::{Model, RandomTerm};
use crate::tested::{Unestimable, at_least};
use std::collections::BTreeMap;
use zwidth_numerics::dense::{Matrix, add_scaled, dot};

/// A column whose part not explained by earlier columns is smaller than this share of its length
/// depends on them.
const DEPENDENT: f64 = 1e-10;
/// A residual sum of squares below this share of the response's own is rounding.
const NO_RESIDUAL: f64 = 1e-26;

/// Row `a`, column `b` ≤ `a` of the factor, or of the covariance matrix, of term `term`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Entry {
    pub(super) term: usize,
    pub(super) a: usize,
    pub(super) b: usize,
}

/// The effects of one level of a term: where they begin among those of a group.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    pub(super) term: usize,
    pub(super) at: usize,
}

/// The groups of one design, summed.
#[derive(Debug, Clone)]
pub(super) struct Pattern {
    /// Number of groups.
    pub(super) groups: f64,
    /// Rows of each.
    pub(super) rows: f64,
    pub(super) blocks: Vec<Block>,
    /// Zᵀ Z, Zᵀ X and Xᵀ X of one group.
    pub(super) ztz: Matrix,
    pub(super) ztx: Matrix,
    pub(super) xtx: Matrix,
    /// Zᵀ y of each group.
    pub(super) each: Vec<Vec<f64>>,
    /// Σ Zᵀ y, Σ Zᵀ y yᵀ Z, Σ Xᵀ y and Σ yᵀ y over groups.
    pub(super) zty: Vec<f64>,
    pub(super) zty_ytz: Matrix,
    pub(super) xty: Vec<f64>,
    pub(super) yty: f64,
}

/// A model and its data, reduced.
#[derive(Debug, Clone)]
pub(super) struct Design {
    pub(super) rows: usize,
    pub(super) groups: usize,
    /// Names of the terms.
    pub(super) names: Vec<String>,
    /// Root mean squares of each term's columns, which they are divided by.
    pub(super) scales: Vec<Vec<f64>>,
    /// The free entries of the terms' factors, in order.
    pub(super) entries: Vec<Entry>,
    pub(super) patterns: Vec<Pattern>,
    /// Least-squares coefficients, R⁻¹ and ln det R of X = Q R.
    pub(super) least_squares: Vec<f64>,
    pub(super) r_inverse: Matrix,
    pub(super) log_det_r: f64,
    /// Residual sum of squares about the least-squares fit.
    pub(super) rss: f64,
}

/// X = Q R, with y's residuals.
struct Orthonormal {
    q: Vec<Vec<f64>>,
    residuals: Vec<f64>,
    least_squares: Vec<f64>,
    r_inverse: Matrix,
    log_det_r: f64,
}

/// Reduces `model`.
pub(super) fn reduce(model: &Model) -> Result<Design, Unestimable> {
    model.check()?;
    let rows = model.response.len();
    at_least("rows", rows, model.fixed.len() + 1)?;
    let fixed = orthonormalise(model)?;
    let rss = dot(&fixed.residuals, &fixed.residuals);
    if rss <= NO_RESIDUAL * dot(&model.response, &model.response) {
        return Err(Unestimable::Constant { units: "values of a condition" });
    }
    let mut scales: Vec<Vec<f64>> = Vec::with_capacity(model.random.len());
    for RandomTerm { columns, .. } in &model.random {
        let squares = columns.iter().map(|column| dot(column, column) / column.len() as f64);
        // A column of zeros is divided by 1: it is refused later, in words.
        let scale = squares.map(f64::sqrt).map(|scale| if scale > 0.0 { scale } else { 1.0 });
        scales.push(scale.collect());
    }
    let patterns = patterns(model, &fixed, &scales);
    let entries = model.random.iter().enumerate().flat_map(|(term, random)| {
        let size = random.columns.len();
        (0..size).flat_map(move |b| (b..size).map(move |a| Entry { term, a, b }))
    });
    Ok(Design {
        rows,
        groups: patterns.iter().map(|p| p.groups as usize).sum(),
        names: model.random.iter().map(|term| term.name.clone()).collect(),
        scales,
        entries: entries.collect(),
        patterns,
        least_squares: fixed.least_squares,
        r_inverse: fixed.r_inverse,
        log_det_r: fixed.log_det_r,
        rss,
    })
}

/// Gram–Schmidt, twice for each column (Giraud et al. 2005: twice is enough), and the residuals of
/// y in the same way.
fn orthonormalise(model: &Model) -> Result<Orthonormal, Unestimable> {
    let p = model.fixed.len();
    let mut q: Vec<Vec<f64>> = Vec::with_capacity(p);
    let mut r = Matrix::zeros(p, p);
    for (j, column) in model.fixed.iter().enumerate() {
        let mut rest = column.values.clone();
        let parts = project_out(&q, &mut rest);
        parts.iter().enumerate().for_each(|(k, part)| r[(k, j)] = *part);
        let length = dot(&rest, &rest).sqrt();
        if length <= DEPENDENT * dot(&column.values, &column.values).sqrt() {
            let before: Vec<&str> = model.fixed[..j].iter().map(|c| c.name.as_str()).collect();
            let what = format!("{} from {}", column.name, before.join(", "));
            return Err(Unestimable::Confounded { what });
        }
        r[(j, j)] = length;
        // Adding 0 makes −0 and 0 the same bits, by which rows are compared.
        rest.iter_mut().for_each(|x| *x = *x / length + 0.0);
        q.push(rest);
    }
    let mut residuals = model.response.clone();
    let parts = project_out(&q, &mut residuals);
    let r_inverse = r.transpose().lower_inverse().transpose();
    Ok(Orthonormal {
        least_squares: r_inverse.times_vector(&parts),
        log_det_r: r.diagonal().iter().map(|d| libm::log(*d)).sum(),
        q,
        residuals,
        r_inverse,
    })
}

/// Subtracts from `v` its parts along the orthonormal `q`, and gives them.
fn project_out(q: &[Vec<f64>], v: &mut [f64]) -> Vec<f64> {
    let mut parts = vec![0.0; q.len()];
    for _ in 0..2 {
        for (part, q) in parts.iter_mut().zip(q) {
            let along = dot(q, v);
            add_scaled(v, -along, q);
            *part += along;
        }
    }
    parts
}

/// One row of a group: the level of each term, the columns of Z and X, and y.
struct Row {
    level: Vec<usize>,
    z: Vec<Vec<f64>>,
    x: Vec<f64>,
    y: f64,
}

impl Row {
    /// The key by which rows of different groups are the same row of one design.
    fn key(&self) -> Vec<u64> {
        let levels = self.level.iter().map(|level| *level as u64);
        let numbers = self.z.iter().flatten().chain(&self.x).map(|x| x.to_bits());
        levels.chain(numbers).collect()
    }
}

/// The groups of each design, summed.
fn patterns(model: &Model, fixed: &Orthonormal, scales: &[Vec<f64>]) -> Vec<Pattern> {
    let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    model.group.iter().enumerate().for_each(|(row, g)| members.entry(*g).or_default().push(row));
    let mut patterns: Vec<Pattern> = Vec::new();
    let mut places: BTreeMap<Vec<Vec<u64>>, usize> = BTreeMap::new();
    for members in members.values() {
        // The rows of one group, levels numbered within it.
        let numbered = model.random.iter().map(|term| {
            let mut levels: Vec<usize> = members.iter().map(|row| term.level[*row]).collect();
            levels.sort_unstable();
            levels.dedup();
            let number = |row: &usize| levels.partition_point(|l| *l < term.level[*row]);
            members.iter().map(number).collect()
        });
        let numbered: Vec<Vec<usize>> = numbered.collect();
        let rows = members.iter().enumerate().map(|(place, row)| {
            let z = model.random.iter().zip(scales).map(|(term, scales)| {
                term.columns.iter().zip(scales).map(|(c, scale)| c[*row] / scale + 0.0).collect()
            });
            Row {
                level: numbered.iter().map(|levels| levels[place]).collect(),
                z: z.collect(),
                x: fixed.q.iter().map(|column| column[*row]).collect(),
                y: fixed.residuals[*row],
            }
        });
        let mut rows: Vec<Row> = rows.collect();
        // Participants who did the same trials in another order share a design.
        rows.sort_by_cached_key(Row::key);
        let key = rows.iter().map(Row::key).collect();
        let at = *places.entry(key).or_insert_with(|| {
            patterns.push(empty_pattern(model, &rows));
            patterns.len() - 1
        });
        let pattern = &mut patterns[at];
        let size = pattern.zty.len();
        let mut zty = vec![0.0; size];
        for row in &rows {
            add_scaled(&mut zty, row.y, &z_row(&pattern.blocks, row, size));
            add_scaled(&mut pattern.xty, row.y, &row.x);
            pattern.yty += row.y * row.y;
        }
        add_scaled(&mut pattern.zty, 1.0, &zty);
        pattern.zty_ytz.add_outer(1.0, &zty, &zty);
        pattern.groups += 1.0;
        pattern.each.push(zty);
    }
    patterns
}

/// The pattern of a group with `rows`, without any response.
fn empty_pattern(model: &Model, rows: &[Row]) -> Pattern {
    let mut blocks = Vec::new();
    let mut size = 0;
    for (term, random) in model.random.iter().enumerate() {
        let levels = rows.iter().map(|row| row.level[term] + 1).max().unwrap_or(0);
        for _ in 0..levels {
            blocks.push(Block { term, at: size });
            size += random.columns.len();
        }
    }
    let p = model.fixed.len();
    let mut pattern = Pattern {
        groups: 0.0,
        rows: rows.len() as f64,
        blocks,
        ztz: Matrix::zeros(size, size),
        ztx: Matrix::zeros(size, p),
        xtx: Matrix::zeros(p, p),
        each: Vec::new(),
        zty: vec![0.0; size],
        zty_ytz: Matrix::zeros(size, size),
        xty: vec![0.0; p],
        yty: 0.0,
    };
    for row in rows {
        let z = z_row(&pattern.blocks, row, size);
        pattern.ztz.add_outer(1.0, &z, &z);
        pattern.ztx.add_outer(1.0, &z, &row.x);
        pattern.xtx.add_outer(1.0, &row.x, &row.x);
    }
    pattern
}

/// One row of Z: the term's columns at the block of its level.
fn z_row(blocks: &[Block], row: &Row, size: usize) -> Vec<f64> {
    let mut z = vec![0.0; size];
    for (term, (level, columns)) in row.level.iter().zip(&row.z).enumerate() {
        let first = blocks.iter().filter(|block| block.term == term).nth(*level);
        let at = first.map_or(0, |block| block.at);
        z[at..at + columns.len()].copy_from_slice(columns);
    }
    z
}
