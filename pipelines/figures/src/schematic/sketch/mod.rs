//! The few pieces of drawings of objects: the environments, and the schematics of model, device and
//! control. Lengths are mm on paper, angles are from upright, clockwise.

mod block;
mod lever;
mod pieces;
mod way;

pub(crate) use block::Block;
pub(crate) use lever::{Lever, UPRIGHT_MM};
pub(crate) use pieces::{
    amid, arrow, damper, disc, flow, ground, left_of, line, over, panel, right_of, ring, spring,
    tint, within,
};
pub(crate) use way::{Point, Way, polar};
