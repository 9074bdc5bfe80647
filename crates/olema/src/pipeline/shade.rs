//! Shade: colour and opacity at the vertices of a grid.
//!
//! In: `Diced`. Out: [`ShadedGrid`], whose colours are made when they are asked for: of all vertices, or of those that
//! something visible uses. Tiles that share a grid share its colours; a vertex has the same bits whoever asks first
//! and whatever else is asked for. Source: Boulos 2010, section 6, for shading after visibility.

use std::sync::{Arc, Mutex, PoisonError};

use glam::{Vec3, Vec4};

use crate::math::Vec3s;
use crate::shading::{OpacityUse, PlacedLight, ShadedPoints, ShadingPoints, SurfaceShader};

use super::dice::{Diced, Implied};
use super::grid::Grid;
use super::spare::GridLists;
use super::waiting::Packed;

/// Colour and opacity of a grid's vertices.
#[derive(Debug, Clone, Default)]
pub struct Colors {
    /// Colour, multiplied by opacity; the fourth component is 0. One load a vertex for resolve, which reads them in no
    /// order. None before any is known, and none for a hole.
    pub color: Vec<Vec4>,
    /// Opacity; empty where all of it is 1.
    pub opacity: Vec3s,
}

/// Vertices of a grid, one bit each.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct VertexSet {
    words: Vec<u64>,
}

impl VertexSet {
    /// Takes all out.
    pub fn clear(&mut self) {
        self.words.clear();
    }

    /// Adds a vertex.
    #[inline(always)]
    pub fn insert(&mut self, vertex: usize) {
        let word = vertex / 64;
        if self.words.len() <= word {
            self.words.resize(word + 1, 0);
        }
        self.words[word] |= 1 << (vertex % 64);
    }

    /// Makes room for vertices below `num`, and a word more.
    pub(super) fn make_room(&mut self, num: usize) {
        self.words.resize(self.words.len().max(num / 64 + 2), 0);
    }

    /// Adds `first + i` where bit i of `bits` is set; there has to be room.
    #[inline(always)]
    pub(super) fn insert_word(&mut self, first: usize, bits: u64) {
        let (word, shift) = (first / 64, first % 64);
        self.words[word] |= bits << shift;
        // Two shifts, as one by 64 is none.
        self.words[word + 1] |= bits >> 1 >> (63 - shift);
    }

    /// Appends its vertices to `list`, in order.
    fn list(&self, list: &mut Vec<u32>) {
        for (&word, first) in self.words.iter().zip((0u32..).step_by(64)) {
            if word == u64::MAX {
                list.extend(first..first + 64);
                continue;
            }
            let mut left = word;
            while left != 0 {
                list.push(first + left.trailing_zeros());
                left &= left - 1;
            }
        }
    }

    /// Whether it holds a vertex.
    pub fn contains(&self, vertex: usize) -> bool {
        self.words.get(vertex / 64).is_some_and(|word| word >> (vertex % 64) & 1 > 0)
    }

    /// Whether it holds none.
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// The vertices, in order.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        let bits = |word: u64| {
            let next = |&left: &u64| Some(left & (left - 1)).filter(|&left| left != 0);
            let lowest = |left: u64| left.trailing_zeros() as usize;
            std::iter::successors(Some(word).filter(|&word| word != 0), next).map(lowest)
        };
        self.words.iter().enumerate().flat_map(move |(ix, &word)| bits(word).map(move |bit| ix * 64 + bit))
    }

    /// Adds all of `other`; those that were not here are put into `new`.
    fn take_new(&mut self, other: &VertexSet, new: &mut VertexSet) {
        let len = self.words.len().max(other.words.len());
        self.words.resize(len, 0);
        let take = |(mine, theirs): (&mut u64, &u64)| {
            let new = theirs & !*mine;
            *mine |= theirs;
            new
        };
        new.words.clear();
        new.words.extend(self.words.iter_mut().zip(&other.words).map(take));
    }

    /// Itself and the neighbours along rows and columns, for a grid of `m` x `n` micropolygons.
    fn with_ring(&self, m: usize, n: usize) -> VertexSet {
        let mut ring = self.clone();
        for vertex in self.iter() {
            let (i, j) = (vertex % (m + 1), vertex / (m + 1));
            let step = m + 1;
            [(i > 0).then(|| vertex - 1), (i < m).then(|| vertex + 1)]
                .into_iter()
                .flatten()
                .for_each(|v| ring.insert(v));
            [(j > 0).then(|| vertex - step), (j < n).then(|| vertex + step)]
                .into_iter()
                .flatten()
                .for_each(|v| ring.insert(v));
        }
        ring
    }
}

/// What shades a grid.
#[derive(Clone, Copy)]
pub struct Shader<'a> {
    /// The surface shader.
    pub surface: &'a dyn SurfaceShader,
    /// Lights, in camera space.
    pub lights: &'a [Arc<dyn PlacedLight>],
}

/// Vertices that were shaded by one call.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ShadedCount {
    /// All of them.
    pub points: u64,
    /// Of these, those shaded only since a neighbour's derivatives need them.
    pub ring: u64,
}

/// A worker's lists for shading, used again for every grid.
#[derive(Debug, Default)]
pub struct ShadeLists {
    new: VertexSet,
    vertices: Vec<u32>,
    /// What a shader writes; what it wrote before for others stays in it.
    shaded: ShadedPoints,
    given: Given,
}

/// Lists of what is [`Implied`].
#[derive(Debug, Default)]
struct Given {
    cs: Alike,
    os: Alike,
    along: Alike,
    i: Vec3s,
    ng: Vec3s,
}

/// A vector as often as it is asked for.
#[derive(Debug, Default)]
struct Alike {
    value: Vec3,
    list: Vec3s,
    /// As far as `list` holds it.
    len: usize,
}

impl Alike {
    fn take(&mut self, value: Vec3, len: usize) -> Vec3s {
        if self.len < len || self.value.to_array().map(f32::to_bits) != value.to_array().map(f32::to_bits) {
            (self.value, self.len) = (value, len);
            self.list.set_len(len);
            let axes = self.list.axes_mut().into_iter().zip(value.to_array());
            axes.for_each(|(axis, component)| axis.fill(component));
        }
        self.list.set_len(len);
        std::mem::take(&mut self.list)
    }
}

impl Given {
    /// Shades with `points` and what is implied.
    fn shade(
        &mut self,
        points: &mut ShadingPoints,
        implied: &Implied,
        vertices: &[u32],
        shader: Shader,
        out: &mut ShadedPoints,
    ) {
        let len = points.p.len();
        let [cs, os, i, ng] = [&points.cs, &points.os, &points.i, &points.ng].map(Vec3s::is_empty);
        if cs {
            points.cs = self.cs.take(implied.cs, len);
        }
        if os {
            points.os = self.os.take(implied.os, len);
        }
        if i && implied.from_eye {
            self.i.assign(&points.p, 0..len);
            std::mem::swap(&mut points.i, &mut self.i);
        } else if i {
            points.i = self.along.take(Vec3::Z, len);
        }
        if ng {
            self.ng.assign(&points.n, 0..points.n.len());
            std::mem::swap(&mut points.ng, &mut self.ng);
        }
        shader.surface.shade(points, vertices, shader.lights, out);
        if cs {
            self.cs.list = std::mem::take(&mut points.cs);
        }
        if os {
            self.os.list = std::mem::take(&mut points.os);
        }
        if i {
            let list = if implied.from_eye { &mut self.i } else { &mut self.along.list };
            *list = std::mem::take(&mut points.i);
        }
        if ng {
            self.ng = std::mem::take(&mut points.ng);
        }
    }
}

/// A grid with its colours, as far as they are known.
#[derive(Debug)]
pub struct ShadedGrid {
    /// Where its vertices are.
    pub grid: Grid,
    /// Whether it is opaque before it is shaded.
    pub surely_opaque: bool,
    shading: Mutex<Shading>,
}

#[derive(Debug)]
struct Shading {
    /// What shaders see; let go of when all vertices are shaded.
    points: Option<Box<ShadingPoints>>,
    implied: Implied,
    colors: Arc<Colors>,
    shaded: VertexSet,
    seen: VertexSet,
}

impl ShadedGrid {
    /// A grid that is not shaded yet.
    pub fn new(diced: Diced, shader: &dyn SurfaceShader) -> Self {
        let Diced { grid, points, implied, left } = diced;
        let keeps = shader.traits().opacity == OpacityUse::Keeps;
        let given_opaque =
            if points.os.is_empty() { implied.os.min_element() >= 1.0 } else { is_opaque(&points.os) };
        let surely_opaque = grid.look.matte || keeps && given_opaque;
        let points = (!grid.look.matte).then(|| Box::new(points));
        let colors = Arc::new(Colors { color: left.color, opacity: Vec3s::default() });
        let (shaded, seen) = (left.shaded, left.seen);
        let shading = Shading { points, implied, colors, shaded, seen };
        ShadedGrid { grid, surely_opaque, shading: Mutex::new(shading) }
    }

    /// Its lists, for another grid.
    pub fn into_lists(self) -> GridLists {
        let Grid { on_raster, packed, depth, .. } = self.grid;
        let Shading { points, colors, shaded, seen, .. } =
            self.shading.into_inner().unwrap_or_else(PoisonError::into_inner);
        let ShadingPoints { p, n, .. } = points.map(|points| *points).unwrap_or_default();
        let color = Arc::into_inner(colors).map(|colors| colors.color).unwrap_or_default();
        let packed = packed.map(Packed::into_values).unwrap_or_default();
        let mut lists = GridLists { on_raster, packed, depth, p, n, color, shaded, seen };
        lists.on_raster.clear();
        lists.depth.clear();
        [&mut lists.p, &mut lists.n].into_iter().for_each(Vec3s::clear);
        lists.color.clear();
        [&mut lists.shaded, &mut lists.seen].into_iter().for_each(VertexSet::clear);
        lists
    }

    /// Shades all vertices, unless that was done before. A hole has no colours and is not shaded.
    pub fn shade_all(&self, shader: Shader) -> (Arc<Colors>, ShadedCount) {
        let mut shading = self.shading.lock().unwrap_or_else(PoisonError::into_inner);
        let mut count = ShadedCount::default();
        if let Some(mut points) = shading.points.take() {
            let vertices: Vec<u32> = (0..self.grid.num_vertices() as u32).collect();
            count.points = vertices.len() as u64;
            let mut shaded = self.blank();
            Given::default().shade(&mut points, &shading.implied, &vertices, shader, &mut shaded);
            let opacity = if is_opaque(&shaded.oi) { Vec3s::default() } else { shaded.oi };
            let color = (0..vertices.len()).map(|vertex| shaded.ci.get(vertex).extend(0.0)).collect();
            shading.colors = Arc::new(Colors { color, opacity });
        }
        (Arc::clone(&shading.colors), count)
    }

    /// Shades those of `wanted` that were not shaded before; the grid is surely opaque. The colours of others are
    /// not to be read.
    pub fn shade_some(
        &self,
        wanted: &VertexSet,
        shader: Shader,
        lists: &mut ShadeLists,
    ) -> (Arc<Colors>, ShadedCount) {
        debug_assert!(self.surely_opaque, "opacity decides what is visible");
        let mut shading = self.shading.lock().unwrap_or_else(PoisonError::into_inner);
        let Shading { points, implied, colors, shaded, .. } = &mut *shading;
        let mut count = ShadedCount::default();
        if let Some(points) = points {
            let ShadeLists { new, vertices, shaded: out, given } = lists;
            shaded.take_new(wanted, new);
            if !new.is_empty() {
                let needs_ring = shader.surface.traits().needs_ring;
                vertices.clear();
                if needs_ring {
                    new.with_ring(self.grid.m as usize, self.grid.n as usize).list(vertices);
                } else {
                    new.list(vertices);
                }
                count.points = vertices.len() as u64;
                count.ring = (vertices.len() - new.len()) as u64;
                let num = self.grid.num_vertices();
                [&mut out.ci, &mut out.oi].into_iter().for_each(|all| all.set_len(num));
                given.shade(points, implied, vertices, shader, out);
                // Other tiles keep the colours they were given.
                let color = &mut Arc::make_mut(colors).color;
                color.resize(num, Vec4::ZERO);
                let [x, y, z] = out.ci.axes();
                for vertex in vertices.iter().map(|&vertex| vertex as usize) {
                    // A vertex of the ring is not right by itself, and may be known already.
                    if !needs_ring || new.contains(vertex) {
                        color[vertex] = Vec4::new(x[vertex], y[vertex], z[vertex], 0.0);
                    }
                }
            }
        }
        (Arc::clone(colors), count)
    }

    /// Lets go of what shaders see, if all vertices are shaded: for a grid that waits for other tiles.
    pub fn let_go_of_points(&self) {
        let mut shading = self.shading.lock().unwrap_or_else(PoisonError::into_inner);
        if shading.shaded.len() == self.grid.num_vertices() {
            shading.points = None;
        }
    }

    /// Notes that something visible uses these vertices; the number of those that nothing used before.
    pub fn note_seen(&self, used: &VertexSet, lists: &mut ShadeLists) -> u64 {
        let mut shading = self.shading.lock().unwrap_or_else(PoisonError::into_inner);
        shading.seen.take_new(used, &mut lists.new);
        lists.new.len() as u64
    }

    fn blank(&self) -> ShadedPoints {
        let of = |value| Vec3s::splat(value, self.grid.num_vertices());
        ShadedPoints { ci: of(Vec3::ZERO), oi: of(Vec3::ONE) }
    }
}

/// Whether all channels of all opacities are 1.
fn is_opaque(opacity: &Vec3s) -> bool {
    opacity.axes().into_iter().all(|values| values.iter().all(|&o| o >= 1.0))
}
