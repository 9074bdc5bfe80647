//! Values and transformations over time.

use std::sync::Arc;

use glam::DMat4;

use crate::math::matrix::between;

/// A value at one or more times, in ascending order of time. One key is a value that does not change; before the
/// first key and after the last a value stays what it is there.
#[derive(Debug, Clone, PartialEq)]
pub struct Keyed<T> {
    /// Key times, strictly ascending, in the unit of `Camera::shutter`. Empty for a single still value.
    pub times: Vec<f32>,
    /// The values, one a time; exactly one where `times` is empty.
    pub values: Vec<T>,
}

/// A place between two keys.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Between {
    /// Keys before and after; the same where the value stands still.
    pub keys: [usize; 2],
    /// Part of the way from the first to the second, in [0, 1).
    pub part: f64,
}

impl<T> Keyed<T> {
    /// A value that does not change.
    pub fn still(value: T) -> Self {
        Keyed { times: Vec::new(), values: vec![value] }
    }

    /// The first key's value.
    pub fn first(&self) -> &T {
        &self.values[0]
    }

    /// Where `time` lies between the keys.
    pub fn locate(&self, time: f64) -> Between {
        let after = self.times.partition_point(|&key| f64::from(key) <= time);
        let last = self.values.len() - 1;
        if after == 0 || after > last {
            let key = if after == 0 { 0 } else { last };
            return Between { keys: [key; 2], part: 0.0 };
        }
        let [from, to] = [after - 1, after].map(|key| f64::from(self.times[key]));
        Between { keys: [after - 1, after], part: (time - from) / (to - from) }
    }
}

impl<T: PartialEq> Keyed<T> {
    /// Whether all keys have the same value.
    pub fn is_still(&self) -> bool {
        self.values.windows(2).all(|pair| pair[0] == pair[1])
    }
}

/// A transformation over time: a product of factors, of which the last is applied to a point first.
///
/// Each factor moves on its own between its keys, along the path of a single motion
/// ([`crate::math::matrix::between`]): a wheel that turns while its car drives does both, exactly.
///
/// Copies share their factors, so that thousands of primitives may stand on one that has thousands of keys.
#[derive(Debug, Clone, PartialEq)]
pub struct Transform {
    /// At least one; of two that follow each other, one moves.
    factors: Arc<Vec<Arc<Keyed<DMat4>>>>,
}

impl Default for Transform {
    fn default() -> Self {
        Transform::still(DMat4::IDENTITY)
    }
}

impl From<Keyed<DMat4>> for Transform {
    fn from(keyed: Keyed<DMat4>) -> Self {
        Transform { factors: Arc::new(vec![Arc::new(keyed)]) }
    }
}

impl Transform {
    /// One that does not move.
    pub fn still(m: DMat4) -> Self {
        Transform::from(Keyed::still(m))
    }

    /// The factors, the last of which is applied first.
    pub fn factors(&self) -> &[Arc<Keyed<DMat4>>] {
        &self.factors
    }

    /// Whether both are one transformation in memory, as that of primitives is between which nothing changed it.
    pub fn is_shared_with(&self, other: &Transform) -> bool {
        Arc::ptr_eq(&self.factors, &other.factors)
    }

    /// Puts a factor next to the object: it is applied before all others.
    pub fn concat(&mut self, m: &Keyed<DMat4>) {
        self.concat_shared(Arc::new(m.clone()));
    }

    fn concat_shared(&mut self, m: Arc<Keyed<DMat4>>) {
        let factors = Arc::make_mut(&mut self.factors);
        match (factors.last_mut(), m.values.len()) {
            (Some(last), 1) if last.values.len() == 1 => Arc::make_mut(last).values[0] *= m.values[0],
            _ => factors.push(m),
        }
    }

    /// The product: `self` applied after `inner`.
    pub fn then_of(&self, inner: &Transform) -> Transform {
        let mut product = self.clone();
        inner.factors.iter().for_each(|factor| product.concat_shared(factor.clone()));
        product
    }

    /// The opposite transformation.
    pub fn inverse(&self) -> Transform {
        let invert = |keyed: &Arc<Keyed<DMat4>>| Keyed {
            times: keyed.times.clone(),
            values: keyed.values.iter().map(DMat4::inverse).collect(),
        };
        Transform { factors: Arc::new(self.factors.iter().rev().map(invert).map(Arc::new).collect()) }
    }

    /// The matrix of all factors' first keys.
    pub fn first(&self) -> DMat4 {
        self.factors.iter().fold(DMat4::IDENTITY, |product, factor| product * *factor.first())
    }

    /// The matrix at a time, in the unit of `Camera::shutter`.
    pub fn at(&self, time: f64) -> DMat4 {
        let mut factors = self.factors.iter().map(|factor| {
            let Between { keys: [a, b], part } = factor.locate(time);
            between(&factor.values[a], &factor.values[b], part)
        });
        let first = factors.next().unwrap_or(DMat4::IDENTITY);
        factors.fold(first, |product, m| product * m)
    }

    /// All key times, ascending; empty for one that is still.
    pub fn times(&self) -> Vec<f32> {
        let mut times: Vec<f32> = self.factors.iter().flat_map(|factor| factor.times.clone()).collect();
        times.sort_by(f32::total_cmp);
        times.dedup();
        times
    }

    /// Whether nothing moves.
    pub fn is_still(&self) -> bool {
        self.factors.iter().all(|factor| factor.is_still())
    }

    /// Whether `check` holds for every matrix of every factor.
    pub fn all(&self, check: impl Fn(&DMat4) -> bool) -> bool {
        self.factors.iter().all(|factor| factor.values.iter().all(&check))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn values_are_held_beyond_their_keys() {
        let keyed = Keyed { times: vec![1.0, 2.0, 4.0], values: vec![0, 1, 2] };
        assert_eq!(keyed.locate(0.0), Between { keys: [0, 0], part: 0.0 });
        assert_eq!(keyed.locate(1.0), Between { keys: [0, 1], part: 0.0 });
        assert_eq!(keyed.locate(3.0), Between { keys: [1, 2], part: 0.5 });
        assert_eq!(keyed.locate(4.0), Between { keys: [2, 2], part: 0.0 });
        assert_eq!(Keyed::still(7).locate(9.0), Between { keys: [0, 0], part: 0.0 });
    }

    #[test]
    fn a_wheel_rolls() {
        let drive = |x: f64| DMat4::from_translation(DVec3::new(x, 0.0, 0.0));
        let mut transform =
            Transform::from(Keyed { times: vec![0.0, 1.0], values: vec![drive(0.0), drive(2.0)] });
        let turn =
            Keyed { times: vec![0.0, 0.5], values: vec![DMat4::IDENTITY, DMat4::from_rotation_z(-1.0)] };
        transform.concat(&turn);
        let hub = transform.at(0.25).transform_point3(DVec3::ZERO);
        assert!((hub - DVec3::new(0.5, 0.0, 0.0)).length() < 1e-14, "{hub}");
        let rim = transform.at(0.25).transform_vector3(DVec3::Y);
        assert!((rim - DVec3::new(0.5f64.sin(), 0.5f64.cos(), 0.0)).length() < 1e-13, "{rim}");
        assert_eq!(transform.times(), [0.0, 0.5, 1.0]);
    }

    #[test]
    fn an_inverse_moves_back_along_the_same_path() {
        let mut transform = Transform::still(DMat4::from_translation(DVec3::X));
        transform.concat(&Keyed {
            times: vec![0.0, 1.0],
            values: vec![DMat4::from_rotation_x(0.2), DMat4::from_rotation_y(1.4)],
        });
        transform.concat(&Keyed::still(DMat4::from_scale(DVec3::splat(3.0))));
        for t in [0.0, 0.3, 1.0] {
            let product = transform.at(t) * transform.inverse().at(t);
            assert!((product - DMat4::IDENTITY).to_cols_array().iter().all(|e| e.abs() < 1e-12));
        }
        assert_eq!(transform.factors().len(), 3);
        assert_eq!(transform.then_of(&Transform::default()).factors().len(), 3);
    }
}
