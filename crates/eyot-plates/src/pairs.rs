//! What pairs of plates remember about each other, for as long as both exist.

/// A table of one number for each pair.
#[derive(Clone, Debug, PartialEq, Default)]
pub(crate) struct Pairs {
    plates: usize,
    values: Vec<f64>,
}

impl Pairs {
    pub(crate) fn new(plates: usize) -> Self {
        Self { plates, values: vec![0.0; plates * plates] }
    }

    pub(crate) fn from_values(plates: usize, values: &[f64]) -> Self {
        Self { plates, values: values.to_vec() }
    }

    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    pub(crate) fn get(&self, p: u8, q: u8) -> f64 {
        self.values[usize::from(p) * self.plates + usize::from(q)]
    }

    pub(crate) fn at(&mut self, p: u8, q: u8) -> &mut f64 {
        &mut self.values[usize::from(p) * self.plates + usize::from(q)]
    }

    pub(crate) fn scale(&mut self, factor: f64) {
        self.values.iter_mut().for_each(|v| *v *= factor);
    }

    /// The same with one more plate, which has no past.
    pub(crate) fn push(&mut self) {
        let mut next = Self::new(self.plates + 1);
        for (p, row) in self.values.chunks(self.plates.max(1)).enumerate() {
            next.values[p * next.plates..][..self.plates].copy_from_slice(row);
        }
        *self = next;
    }

    /// The same for the plates that `keep` lists, in its order.
    pub(crate) fn keep(&mut self, keep: &[usize]) {
        let values = keep.iter().flat_map(|&p| keep.iter().map(move |&q| (p, q)));
        self.values = values.map(|(p, q)| self.values[p * self.plates + q]).collect();
        self.plates = keep.len();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_survive_newcomers_and_losses() {
        let mut t = Pairs::new(2);
        *t.at(0, 1) = 3.0;
        *t.at(1, 0) = 4.0;
        t.push();
        assert_eq!((t.get(0, 1), t.get(1, 0), t.get(2, 1)), (3.0, 4.0, 0.0));
        *t.at(2, 1) = 5.0;
        t.keep(&[2, 1]);
        assert_eq!((t.get(0, 1), t.get(1, 0)), (5.0, 0.0));
    }
}
