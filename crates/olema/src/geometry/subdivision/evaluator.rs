//! Evaluation of one base quad.
//!
//! In: a [`LimitSurface`] and a base quad. Out: limit points, derivatives, boxes and primitive variables at
//! (u, v) in the unit square. An evaluator keeps what it has refined, so that the next point nearby is
//! cheap; what it answers depends on (quad, key, u, v) alone, bit for bit.

use glam::{DVec3, Vec3};

use super::bicubic::{Bicubic, Jet};
use super::hood::{Channel, Hood};
use super::surface::{LimitSurface, Var, var_channels, var_width};
use super::topology::Topology;
use super::tree::{Place, Tree};
use crate::scene::{Scheme, VarValues};

/// A point of the limit surface and its first derivatives in object space.
///
/// At extraordinary vertices the derivatives are tangents along the two sides, of the length that the limit
/// mask gives them; the true ones are zero or infinite there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LimitPoint {
    /// Position.
    pub p: Vec3,
    /// Derivative by u.
    pub dp_du: Vec3,
    /// Derivative by v.
    pub dp_dv: Vec3,
}

impl LimitPoint {
    /// Unit normal dp_du x dp_dv, or `None` where the derivatives vanish or are parallel (a collapsed edge, a
    /// cusp): see [`Evaluator::normal`].
    pub fn normal(&self) -> Option<Vec3> {
        let (du, dv) = (self.dp_du.as_dvec3(), self.dp_dv.as_dvec3());
        let n = du.cross(dv);
        // Below a millionth of a radian, what is left of f32 derivatives is rounding.
        let lengths = du.length_squared() * dv.length_squared();
        (n.length_squared() > 1e-12 * lengths).then(|| (n / n.length()).as_vec3())
    }
}

/// A box in object space, closed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Lowest coordinates.
    pub min: Vec3,
    /// Highest coordinates.
    pub max: Vec3,
}

/// A B-spline that the limit surface is over a base quad or a part of it.
#[derive(Debug, Clone, Copy)]
pub struct Spline<'a> {
    spline: &'a Bicubic,
    /// By how much derivatives grow from the part to the quad: a power of two.
    scale: f64,
}

/// A part of a base quad over which the limit surface is one B-spline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part(Place);

impl Spline<'_> {
    /// What [`Evaluator::evaluate`] gives, at (u, v) in the part.
    #[inline(always)]
    pub fn evaluate(&self, u: f32, v: f32) -> LimitPoint {
        let jet = self.spline.evaluate(f64::from(u), f64::from(v));
        let (du, dv) = (jet.du * self.scale, jet.dv * self.scale);
        LimitPoint { p: jet.p.as_vec3(), dp_du: du.as_vec3(), dp_dv: dv.as_vec3() }
    }
}

/// Evaluates one base quad of a [`LimitSurface`].
#[derive(Debug, Clone)]
pub struct Evaluator<'a> {
    surface: &'a LimitSurface,
    face: u32,
    corner: u32,
    shape: Shape,
    /// Trees of smooth facevarying variables, made when first asked for.
    values: Vec<(usize, Tree)>,
}

/// What the base quad's limit surface is made from.
#[derive(Debug, Clone)]
enum Shape {
    Quad(Tree),
    Triangle(Tree),
    /// Corner values a channel.
    Bilinear(Vec<[DVec3; 4]>),
}

impl<'a> Evaluator<'a> {
    pub(super) fn new(surface: &'a LimitSurface, face: u32, corner: u32) -> Self {
        let channels = surface.channels();
        let shape = match surface.mesh.scheme {
            Scheme::Bilinear => Shape::Bilinear(
                channels.iter().map(|c| linear_corners(surface, face, corner, |i| c.get(i.vertex))).collect(),
            ),
            Scheme::CatmullClark => Shape::Quad(tree(surface, &surface.topology, face, corner, &channels)),
            Scheme::Loop => Shape::Triangle(tree(surface, &surface.topology, face, corner, &channels)),
        };
        Evaluator { surface, face, corner, shape, values: Vec::new() }
    }

    /// Bytes that the evaluator holds by now.
    pub fn num_bytes(&self) -> usize {
        let shape = match &self.shape {
            Shape::Quad(tree) | Shape::Triangle(tree) => tree.num_bytes(),
            Shape::Bilinear(corners) => size_of_val(corners.as_slice()),
        };
        size_of::<Self>() + shape + self.values.iter().map(|(_, tree)| tree.num_bytes()).sum::<usize>()
    }

    /// The limit point of key `key` (below [`LimitSurface::num_keys`]) at (u, v), both in [0, 1].
    pub fn evaluate(&mut self, key: usize, u: f32, v: f32) -> LimitPoint {
        let (jet, defined) = self.jet(key, u, v);
        let mut point = LimitPoint { p: jet.p.as_vec3(), dp_du: jet.du.as_vec3(), dp_dv: jet.dv.as_vec3() };
        if !defined {
            // A sharp corner without a tangent plane, or a vertex of two faces: that of a place just inside.
            let (inside, _) = self.jet(key, inwards(u, 1.0 / 1024.0), inwards(v, 1.0 / 1024.0));
            (point.dp_du, point.dp_dv) = (inside.du.as_vec3(), inside.dv.as_vec3());
        }
        point
    }

    /// The surface of a key, if it is one spline over the whole base quad.
    pub fn spline(&self, key: usize) -> Option<Spline<'_>> {
        match &self.shape {
            Shape::Quad(tree) => tree.spline(key).map(|spline| Spline { spline, scale: 1.0 }),
            _ => None,
        }
    }

    /// Finds the parts of the base quad that points lie in, and where in them: appends an entry each to `out`, `None` for
    /// what is no B-spline's. They are good until anything else is asked.
    pub fn parts(&mut self, uv: [&[f32]; 2], out: &mut Vec<Option<(Part, [f32; 2])>>) {
        let mut places = Vec::with_capacity(uv[0].len());
        match &mut self.shape {
            Shape::Quad(tree) => tree.splines_at(uv, &mut places),
            _ => places.resize(uv[0].len(), None),
        }
        out.extend(places.into_iter().map(|found| found.map(|(place, uv)| (Part(place), uv))));
    }

    /// The surface of a key over a part.
    pub fn spline_of(&self, part: Part, key: usize) -> Option<Spline<'_>> {
        match &self.shape {
            Shape::Quad(tree) => tree.spline_of(part.0, key).map(|(spline, scale)| Spline { spline, scale }),
            _ => None,
        }
    }

    /// The limit points of all keys at (u, v), appended to `out`.
    pub fn evaluate_keys(&mut self, u: f32, v: f32, out: &mut Vec<LimitPoint>) {
        for key in 0..self.surface.num_keys() {
            let point = self.evaluate(key, u, v);
            out.push(point);
        }
    }

    /// The unit normal at (u, v), where `point` lies: its own, or where that is undefined one from ever
    /// further inside the base quad; `None` if there is none either (a quad without area).
    pub fn normal(&mut self, key: usize, u: f32, v: f32, point: &LimitPoint) -> Option<Vec3> {
        let steps = [1.0 / 1024.0, 1.0 / 64.0, 0.25, 1.0];
        point.normal().or_else(|| {
            steps.into_iter().find_map(|s| self.evaluate(key, inwards(u, s), inwards(v, s)).normal())
        })
    }

    /// A box that holds the surface of key `key` over `u` x `v`, tight but for the neighbourhood of
    /// extraordinary vertices. Ranges are ascending and within [0, 1].
    pub fn bounds(&mut self, key: usize, u: [f32; 2], v: [f32; 2]) -> Aabb {
        let (u, v) = (u.map(f64::from), v.map(f64::from));
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut grow = |p: DVec3| (min, max) = (min.min(p), max.max(p));
        match &mut self.shape {
            Shape::Quad(tree) => tree.quad_hull(u, v, key, &mut grow),
            Shape::Bilinear(corners) => {
                for (u, v) in [(u[0], v[0]), (u[1], v[0]), (u[0], v[1]), (u[1], v[1])] {
                    grow(bilinear(&corners[key], u, v).p);
                }
            }
            Shape::Triangle(tree) => {
                // Lines of constant u or v are straight in the triangle.
                let corner = |(u, v)| barycentric(self.corner, u, v).0;
                let part = [(u[0], v[0]), (u[1], v[0]), (u[1], v[1]), (u[0], v[1])].map(corner);
                tree.triangle_hull(&part, key, &mut grow);
            }
        }
        // Rounding of the points and of the conversion to f32.
        let pad = (max - min).max(DVec3::ZERO) * 1e-9;
        let down = |x: f64| (x as f32).next_down();
        let up = |x: f64| (x as f32).next_up();
        let (min, max) = (min - pad, max + pad);
        Aabb {
            min: Vec3::new(down(min.x), down(min.y), down(min.z)),
            max: Vec3::new(up(max.x), up(max.y), up(max.z)),
        }
    }

    /// The value of variable `var` of the mesh at (u, v) into `out`, which has a value's number of floats.
    /// Returns whether there is one: strings and variables that were left out have none.
    pub fn var(&mut self, var: usize, u: f32, v: f32, out: &mut [f32]) -> bool {
        let surface = self.surface;
        let description = &surface.mesh.vars[var];
        let VarValues::Floats(data) = &description.values else {
            return false;
        };
        let width = var_width(description);
        let copy = |ix: usize, out: &mut [f32]| out.copy_from_slice(&data[ix * width..(ix + 1) * width]);
        let (face, corner) = (self.face, self.corner);
        let linear = |place: fn(CornerOf) -> u32, out: &mut [f32]| {
            for (channel, out) in var_channels(data, width, None).zip(out.chunks_mut(3)) {
                let corners = linear_corners(surface, face, corner, |c| channel.get(place(c)));
                store(bilinear(&corners, f64::from(u), f64::from(v)).p, out);
            }
        };
        match &surface.vars[var] {
            Var::None => return false,
            Var::Constant => copy(0, out),
            Var::Uniform => copy(surface.topology.faces.source_face[face as usize] as usize, out),
            Var::Varying => linear(|c| c.vertex, out),
            Var::FaceLinear => linear(|c| c.source, out),
            Var::Vertex(first) => {
                for (i, out) in out.chunks_mut(3).enumerate() {
                    store(self.jet(first + i, u, v).0.p, out);
                }
            }
            Var::FaceSmooth(_) => self.face_smooth(var, u, v, out),
        }
        true
    }

    /// A facevarying variable with rules of its own.
    fn face_smooth(&mut self, var: usize, u: f32, v: f32, out: &mut [f32]) {
        let surface = self.surface;
        let (Var::FaceSmooth(sheet), VarValues::Floats(data)) =
            (&surface.vars[var], &surface.mesh.vars[var].values)
        else {
            return;
        };
        let width = var_width(&surface.mesh.vars[var]);
        let found = self.values.iter().position(|t| t.0 == var);
        let place = found.unwrap_or_else(|| {
            let channels: Vec<_> = var_channels(data, width, Some(&sheet.source)).collect();
            let tree = tree(surface, &sheet.topology, self.face, self.corner, &channels);
            self.values.push((var, tree));
            self.values.len() - 1
        });
        let tree = &mut self.values[place].1;
        let is_loop = surface.mesh.scheme == Scheme::Loop;
        for (i, out) in out.chunks_mut(3).enumerate() {
            let jet = tree_jet(tree, is_loop, self.corner, i, f64::from(u), f64::from(v)).0;
            store(jet.p, out);
        }
    }

    fn jet(&mut self, channel: usize, u: f32, v: f32) -> (Jet, bool) {
        let (u, v) = (f64::from(u), f64::from(v));
        match &mut self.shape {
            Shape::Quad(tree) => tree_jet(tree, false, self.corner, channel, u, v),
            Shape::Triangle(tree) => tree_jet(tree, true, self.corner, channel, u, v),
            Shape::Bilinear(corners) => (bilinear(&corners[channel], u, v), true),
        }
    }
}

/// The tree of a base quad (a whole triangle under Loop).
fn tree(
    surface: &LimitSurface,
    topology: &Topology,
    face: u32,
    corner: u32,
    channels: &[Channel<'_>],
) -> Tree {
    let method = surface.mesh.crease_method;
    if surface.mesh.scheme == Scheme::Loop {
        return Tree::new(&Hood::of_triangle(topology, face, channels), method);
    }
    let polygon = Hood::of_polygon(topology, face, channels);
    match surface.is_whole(face) {
        true => Tree::new(&polygon, method),
        false => Tree::of_corner(&polygon, corner, method),
    }
}

/// The jet of a channel, and whether its derivatives are defined.
fn tree_jet(tree: &mut Tree, is_loop: bool, corner: u32, channel: usize, u: f64, v: f64) -> (Jet, bool) {
    if is_loop {
        let (b, directions) = barycentric(corner, u, v);
        tree.triangle_jet(b, directions, channel)
    } else {
        tree.quad_jet([u, v], channel)
    }
}

/// Barycentric coordinates in a triangle of (u, v) in its base quad at `corner`, and their derivatives. The
/// quad's corners are the triangle's corner, two edge middles and the triangle's middle; bilinear between.
fn barycentric(corner: u32, u: f64, v: f64) -> ([f64; 3], [[f64; 3]; 2]) {
    let around = |next: f64, prev: f64, sum: f64| {
        let mut b = [0.0; 3];
        for (i, x) in [sum - next - prev, next, prev].into_iter().enumerate() {
            b[(corner as usize + i) % 3] = x;
        }
        b
    };
    let both = u * v / 6.0;
    (
        around(0.5 * u - both, 0.5 * v - both, 1.0),
        [around(0.5 - v / 6.0, -v / 6.0, 0.0), around(-u / 6.0, 0.5 - u / 6.0, 0.0)],
    )
}

/// A corner of a face: its vertex, and its place in the mesh as given.
#[derive(Clone, Copy)]
struct CornerOf {
    vertex: u32,
    source: u32,
}

/// Values at the corners of a base quad: at a face's corners as they are, between them their means.
fn linear_corners(
    surface: &LimitSurface,
    face: u32,
    corner: u32,
    value: impl Fn(CornerOf) -> DVec3,
) -> [DVec3; 4] {
    let faces = &surface.topology.faces;
    let range = faces.corners(face);
    let n = range.len();
    let at = |i: usize| {
        let c = range.start as usize + i % n;
        value(CornerOf { vertex: faces.vertex[c], source: faces.source_corner[c] })
    };
    if surface.is_whole(face) {
        return [at(0), at(1), at(2), at(3)];
    }
    let own = corner as usize;
    let middle = (0..n).map(at).sum::<DVec3>() / n as f64;
    [at(own), (at(own) + at(own + 1)) * 0.5, middle, (at(own) + at(own + n - 1)) * 0.5]
}

/// Point and derivatives between four corners at (0, 0), (1, 0), (1, 1), (0, 1).
fn bilinear([a, b, c, d]: &[DVec3; 4], u: f64, v: f64) -> Jet {
    let (low, high) = (a.lerp(*b, u), d.lerp(*c, u));
    Jet { p: low.lerp(high, v), du: (*b - *a).lerp(*c - *d, v), dv: high - low }
}

/// Moves a parameter towards the middle of its range.
fn inwards(t: f32, step: f32) -> f32 {
    t + (0.5 - t) * step
}

fn store(value: DVec3, out: &mut [f32]) {
    for (to, from) in out.iter_mut().zip(value.to_array()) {
        *to = from as f32;
    }
}
