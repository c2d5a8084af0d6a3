//! Pure maths of rays against shapes, in f32, as the fast tracers do it and as `shaders/shared` repeats it.
//!
//! Nothing here knows a scene. Degenerate shapes are a miss, never NaN; directions have a length.

mod aabb;
mod affine;
mod basis;
mod cone;
mod cuboid;
mod disc;
mod moller_trumbore;
mod offset;
mod plane;
mod point;
mod ray;
mod sphere;
mod torus;
mod triangle;
mod trig;
mod unit;

pub use aabb::Aabb;
pub use affine::AffineRows;
pub use basis::out_of_frame;
pub use cone::{CONE_CAP_A, CONE_CAP_B, CONE_SIDE, cone_point, cone_radius, intersect_cone};
pub use cuboid::{cuboid_normal, intersect_cuboid};
pub use disc::intersect_disc;
pub use moller_trumbore::intersect_triangle_unshared;
pub use offset::{affine_error, gamma, offset_origin, step_off};
pub use plane::PlaneFrame;
pub use point::SolidPoint;
pub use ray::{FAR_WIDENING, SlabRay, safe_reciprocal};
pub use sphere::{SphereFrame, SphereHeight, SphereRoots};
pub use torus::{intersect_torus, torus_point};
pub use triangle::{Shear, TriangleHit};
pub use trig::{angle_of, sin_cos};
pub use unit::unit_or;
