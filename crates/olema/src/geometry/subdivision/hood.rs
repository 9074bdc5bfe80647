//! Neighbourhoods: a face with the fans of faces around its corners, all that its limit surface depends on.
//!
//! In: [`Topology`] and control values, for a face of the control mesh. Out: [`Hood`]. Refining one gives
//! the neighbourhoods of its children ([`quad`](super::quad), [`triangle`](super::triangle)), and so on as
//! deep as wanted: nothing outside is ever read again.
//!
//! Each corner has a *ring* of its own; points that two rings have in common are held twice. That costs a
//! little arithmetic and saves all bookkeeping. A ring counts counter-clockwise:
//!
//! ```text
//!       f1  e1  f0          e: far ends of the edges
//!        \  |  /            f: far corners of the faces; face k lies between edge k and k + 1
//!   e2 -- vertex -- e0      open rings begin and end at a border: n faces, n + 1 edges
//!        /  |  \
//!       f2  e3  f3          Under Loop a ring has no far corners, only e.
//! ```

use glam::DVec3;

use super::topology::{Fan, Topology};

/// Control values of a sheet: channels of up to three floats a vertex.
pub(super) struct Channel<'a> {
    /// The floats.
    pub(super) data: &'a [f32],
    /// Floats from one vertex to the next.
    pub(super) stride: usize,
    /// First float of a vertex.
    pub(super) offset: usize,
    /// Floats taken, 1 to 3.
    pub(super) width: usize,
    /// Place of each vertex's value, where it is not the vertex itself.
    pub(super) source: Option<&'a [u32]>,
}

impl Channel<'_> {
    /// The value of a vertex; missing components are 0.
    pub(super) fn get(&self, vertex: u32) -> DVec3 {
        let place = self.source.map_or(vertex, |s| s[vertex as usize]);
        let first = place as usize * self.stride + self.offset;
        let mut v = [0.0; 3];
        for (to, from) in v.iter_mut().zip(&self.data[first..first + self.width]) {
            *to = f64::from(*from);
        }
        DVec3::from(v)
    }
}

/// One corner's ring.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ring {
    /// Place of edge 0's far end among the points; the vertex itself stands just before it.
    pub(super) first: u32,
    /// Points a face: 2 with far corners, 1 without.
    pub(super) step: u32,
    /// Place of edge 0's sharpness.
    pub(super) first_sharpness: u32,
    pub(super) num_faces: u32,
    /// Whether the last face touches the first.
    pub(super) closed: bool,
    /// The hood's own face in the fan: its edge to the next corner is edge `at`, to the one before `at + 1`.
    pub(super) at: u32,
    /// Sharpness of the vertex.
    pub(super) corner: f32,
}

impl Ring {
    pub(super) fn num_edges(&self) -> u32 {
        self.num_faces + u32::from(!self.closed)
    }

    /// Points of the ring without its vertex.
    pub(super) fn num_points(&self) -> u32 {
        self.num_faces * self.step + u32::from(!self.closed)
    }

    pub(super) fn vertex(&self) -> usize {
        self.first as usize - 1
    }

    /// Far end of edge `k`, counted around in a closed ring.
    pub(super) fn edge(&self, k: i32) -> usize {
        (self.first + self.edge_ix(k) * self.step) as usize
    }

    /// Far corner of face `k`, counted around in a closed ring.
    pub(super) fn far(&self, k: i32) -> usize {
        let n = self.num_faces as i32;
        let k = if self.closed { k.rem_euclid(n) } else { k };
        debug_assert!((0..n).contains(&k), "face {k} of an open ring of {n}");
        (self.first + k as u32 * self.step + 1) as usize
    }

    fn edge_ix(&self, k: i32) -> u32 {
        let n = self.num_edges() as i32;
        let k = if self.closed { k.rem_euclid(n) } else { k };
        debug_assert!((0..n).contains(&k), "edge {k} of an open ring of {n}");
        k as u32
    }

    /// Places of the edges' sharpness.
    pub(super) fn sharpness_range(&self) -> std::ops::Range<usize> {
        let first = self.first_sharpness as usize;
        first..first + self.num_edges() as usize
    }

    /// Whether the own face's edge to the next corner is a border or infinite crease.
    pub(super) fn next_is_border(&self) -> bool {
        !self.closed && self.at == 0
    }

    /// Whether the own face's edge to the corner before is a border or infinite crease.
    pub(super) fn prev_is_border(&self) -> bool {
        !self.closed && self.at + 1 == self.num_faces
    }
}

/// A face and its surroundings at one level of subdivision.
#[derive(Debug, Clone, Default)]
pub(super) struct Hood {
    /// A ring a corner, counter-clockwise.
    pub(super) rings: Vec<Ring>,
    /// Sharpness of the rings' edges, ring after ring.
    pub(super) sharpness: Vec<f32>,
    /// Channel after channel: vertex and ring of each corner, relative to the channel's origin.
    pub(super) points: Vec<DVec3>,
    /// One a channel. It moves along with the hood: however small the hood, its points keep all their bits.
    pub(super) origins: Vec<DVec3>,
    /// Points a channel.
    pub(super) num_points: usize,
    /// The far corners are the faces' middles: some face around is no quad (control mesh only).
    pub(super) has_middles: bool,
}

impl Hood {
    /// Points of one channel.
    pub(super) fn channel(&self, channel: usize) -> &[DVec3] {
        &self.points[channel * self.num_points..(channel + 1) * self.num_points]
    }

    /// Number of channels.
    pub(super) fn num_channels(&self) -> usize {
        self.origins.len()
    }

    /// Makes this a copy of `other` with its own memory.
    pub(super) fn copy_from(&mut self, other: &Hood) {
        self.rings.clone_from(&other.rings);
        self.sharpness.clone_from(&other.sharpness);
        self.points.clone_from(&other.points);
        self.origins.clone_from(&other.origins);
        (self.num_points, self.has_middles) = (other.num_points, other.has_middles);
    }

    /// Empties it but for its memory.
    pub(super) fn clear(&mut self) {
        self.rings.clear();
        self.sharpness.clear();
        self.points.clear();
        self.origins.clear();
        self.has_middles = false;
    }

    /// Takes from `fine`, channel by channel, the points at `sources`, and makes the first of them the origin.
    pub(super) fn take_points(&mut self, fine: &Hood, sources: &[usize]) {
        self.num_points = sources.len();
        self.points.reserve(sources.len() * fine.num_channels());
        for channel in 0..fine.num_channels() {
            let points = fine.channel(channel);
            let shift = points[sources[0]];
            self.origins.push(fine.origins[channel] + shift);
            self.points.extend(sources.iter().map(|&s| points[s] - shift));
        }
    }

    /// Sharpness of the edges of corner `c`'s ring.
    pub(super) fn ring_sharpness(&self, c: usize) -> &[f32] {
        &self.sharpness[self.rings[c].sharpness_range()]
    }

    /// Whether the corner has a limit mask: nothing about it will lose sharpness any more, and it is not the
    /// end of an infinite crease, whose subdivision matrix has no eigenvectors of a simple form.
    pub(super) fn has_mask(&self, c: usize) -> bool {
        let settled = |s: f32| s == 0.0 || s == f32::INFINITY;
        let (ring, edges) = (self.rings[c], self.ring_sharpness(c));
        let ends_crease = ring.corner == 0.0 && edges.iter().filter(|s| **s > 0.0).count() == 1;
        settled(ring.corner) && edges.iter().all(|&s| settled(s)) && !ends_crease && !self.has_middles
    }

    /// The neighbourhood of a face of the control mesh, for Catmull-Clark.
    pub(super) fn of_polygon(topology: &Topology, face: u32, channels: &[Channel<'_>]) -> Hood {
        let mut fans: Vec<_> = topology.faces.corners(face).map(|c| topology.fan(c)).collect();
        let is_quad = |&c: &u32| topology.faces.vertices(topology.face[c as usize]).len() == 4;
        let has_middles = !fans.iter().all(|fan| fan.corners.iter().all(is_quad));
        let mut builder = Builder::new(2);
        let mut sources = Vec::new();
        for fan in &mut fans {
            builder.ring(topology, fan);
            sources.push(Source::Vertex(topology.vertex(fan.corners[0])));
            for &c in &fan.corners {
                sources.push(Source::Vertex(topology.vertex(topology.next(c))));
                let far = topology.next(topology.next(c));
                sources.push(match has_middles {
                    true => Source::Middle(topology.face[c as usize]),
                    false => Source::Vertex(topology.vertex(far)),
                });
            }
            builder.last_edge(topology, fan, &mut sources);
        }
        builder.finish(topology, sources, channels, has_middles)
    }

    /// The neighbourhood of a triangle of the control mesh, for Loop.
    pub(super) fn of_triangle(topology: &Topology, face: u32, channels: &[Channel<'_>]) -> Hood {
        let mut builder = Builder::new(1);
        let mut sources = Vec::new();
        for corner in topology.faces.corners(face) {
            let mut fan = topology.fan(corner);
            builder.ring(topology, &mut fan);
            sources.push(Source::Vertex(topology.vertex(corner)));
            for &c in &fan.corners {
                sources.push(Source::Vertex(topology.vertex(topology.next(c))));
            }
            builder.last_edge(topology, &fan, &mut sources);
        }
        builder.finish(topology, sources, channels, false)
    }
}

/// Memory for refining, used again and again: most hoods turn into splines as soon as they are made.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch {
    /// The refinement of the last hood.
    pub(super) fine: Hood,
    /// Its last child.
    pub(super) child: Hood,
    /// Where the child's points stand in `fine`.
    pub(super) sources: Vec<usize>,
}

/// Where a point of a control mesh's ring comes from.
enum Source {
    Vertex(u32),
    Middle(u32),
}

/// Lays out rings one after the other.
struct Builder {
    hood: Hood,
    step: u32,
    open: bool,
}

impl Builder {
    fn new(step: u32) -> Self {
        Builder { hood: Hood::default(), step, open: false }
    }

    /// Adds the ring of a fan and restricts the fan to the faces that it keeps, in order.
    fn ring(&mut self, topology: &Topology, fan: &mut Fan) {
        let mut sharpness: Vec<f32> = fan.corners.iter().map(|&c| sharpness_of(topology, c)).collect();
        if !fan.closed {
            sharpness.push(f32::INFINITY);
        }
        let whole = Ring {
            first: self.hood.num_points as u32 + 1,
            step: self.step,
            first_sharpness: self.hood.sharpness.len() as u32,
            num_faces: fan.corners.len() as u32,
            closed: fan.closed,
            at: fan.at,
            corner: topology.vertex_sharpness[topology.vertex(fan.corners[0]) as usize],
        };
        let (ring, first) = cut(whole, &sharpness);
        fan.corners.rotate_left(first);
        fan.corners.truncate(ring.num_faces as usize);
        let n = sharpness.len();
        self.hood.sharpness.extend((0..ring.num_edges() as usize).map(|k| sharpness[(first + k) % n]));
        self.hood.num_points += 1 + ring.num_points() as usize;
        self.open = !ring.closed;
        self.hood.rings.push(ring);
    }

    /// Adds the far end of an open ring's last edge.
    fn last_edge(&self, topology: &Topology, fan: &Fan, sources: &mut Vec<Source>) {
        if let Some(&last) = fan.corners.last()
            && self.open
        {
            sources.push(Source::Vertex(topology.vertex(topology.prev(last))));
        }
    }

    fn finish(
        mut self,
        topology: &Topology,
        sources: Vec<Source>,
        channels: &[Channel<'_>],
        has_middles: bool,
    ) -> Hood {
        debug_assert_eq!(sources.len(), self.hood.num_points, "one source a point");
        for channel in channels {
            self.hood.origins.push(DVec3::ZERO);
            self.hood.points.extend(sources.iter().map(|source| match *source {
                Source::Vertex(v) => channel.get(v),
                Source::Middle(face) => {
                    let vertices = topology.faces.vertices(face);
                    vertices.iter().map(|&v| channel.get(v)).sum::<DVec3>() / vertices.len() as f64
                }
            }));
        }
        self.hood.has_middles = has_middles;
        self.hood
    }
}

fn sharpness_of(topology: &Topology, corner: u32) -> f32 {
    topology.edges[topology.edge[corner as usize] as usize].sharpness
}

/// Restricts a ring to the sector of its own face between two infinite creases, if it lies in one and
/// nothing outside can matter any more. Returns the ring, with `first` and `first_sharpness` unchanged, and
/// the place of its first face in the old one, from where it may run over the end.
///
/// Nothing outside matters once no edge is semi-sharp: on a crease the vertex depends on the two crease
/// edges alone, which bound the sector; with more sharp edges it stays where it is.
pub(super) fn cut(ring: Ring, sharpness: &[f32]) -> (Ring, usize) {
    let num_sharp = sharpness.iter().filter(|s| **s > 0.0).count();
    if num_sharp < 2 || sharpness.iter().any(|&s| s > 0.0 && s < f32::INFINITY) {
        return (ring, 0);
    }
    let n = ring.num_edges() as usize;
    let mut first = ring.at as usize;
    while sharpness[first] == 0.0 {
        first = if first == 0 { n - 1 } else { first - 1 };
    }
    let mut num_faces = 1;
    while sharpness[(first + num_faces) % n] == 0.0 {
        num_faces += 1;
    }
    let own = (ring.at as usize + n - first) % n;
    let corner = if num_sharp > 2 { f32::INFINITY } else { ring.corner };
    let sector = Ring { num_faces: num_faces as u32, closed: false, at: own as u32, corner, ..ring };
    (sector, first)
}
