//! Graphs: places and the directed lines between them, such as river networks and chains of lakes.

use super::{Attributes, Component, ComponentKind, Encoder, Points, Shape, Type, View};
use crate::error::{Error, Result};
use crate::fingerprint::Fingerprint;
use std::borrow::Cow;
use std::sync::Arc;

/// Nodes with positions and attributes, and directed edges with attributes of their own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Graph {
    nodes: Points,
    edges: Vec<[u32; 2]>,
    attributes: Attributes,
}

pub(super) static KIND: ComponentKind = ComponentKind {
    name: "graph",
    version: 1,
    formerly: &[],
    decode: |_, from| {
        let nodes = Points::decode(from)?;
        let n = from.count(8)?;
        let edges: Vec<[u32; 2]> = from.u32s(2 * n)?.chunks_exact(2).map(|e| [e[0], e[1]]).collect();
        if let Some([a, b]) = edges.iter().find(|e| e.iter().any(|i| *i as usize >= nodes.len())) {
            return Err(from.wrong(format!("an edge from {a} to {b} among {} nodes", nodes.len())));
        }
        let attributes = Attributes::decode(n, from)?;
        Ok(Arc::new(Graph { nodes, edges, attributes }))
    },
};

impl Graph {
    /// No edges yet between these nodes, with attributes by name, unit and type.
    pub fn new<'a>(nodes: Points, attributes: impl IntoIterator<Item = (&'a str, &'a str, Type)>) -> Self {
        Self { nodes, edges: Vec::new(), attributes: Attributes::new(attributes) }
    }

    /// Adds a node and returns its number.
    ///
    /// # Errors
    /// As [`Points::push`], and if there are no numbers left.
    pub fn push_node(&mut self, position: [f32; 3], row: &[f64]) -> Result<u32> {
        let number = u32::try_from(self.nodes.len()).map_err(|_| Error::Limit {
            what: "a graph".into(),
            needed: format!("{} nodes", self.nodes.len() + 1),
            limit: format!("{} nodes", u32::MAX),
            remedy: "choose a smaller grid".into(),
        })?;
        self.nodes.push(position, row)?;
        Ok(number)
    }

    /// Adds an edge between two nodes that are there.
    ///
    /// # Errors
    /// If one of them is not, or `row` does not fit the edges' attributes.
    pub fn push_edge(&mut self, from: u32, to: u32, row: &[f64]) -> Result<()> {
        if let Some(missing) = [from, to].into_iter().find(|i| *i as usize >= self.nodes.len()) {
            let reason = format!("an edge at node {missing} of {}", self.nodes.len());
            return Err(Error::Component { name: "graph".into(), reason });
        }
        self.attributes.push(row)?;
        self.edges.push([from, to]);
        Ok(())
    }

    /// The places.
    pub const fn nodes(&self) -> &Points {
        &self.nodes
    }

    /// Numbers of the nodes from and to which each edge goes.
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// What else is known of the edges.
    pub const fn edge_attributes(&self) -> &Attributes {
        &self.attributes
    }

    /// For each node where its edges begin in the list behind, and one number more; and in that list, node by node, the numbers of the
    /// edges that leave it.
    pub fn outgoing(&self) -> (Vec<usize>, Vec<u32>) {
        let mut starts = vec![0; self.nodes.len() + 1];
        self.edges.iter().for_each(|[from, _]| starts[*from as usize + 1] += 1);
        (0..self.nodes.len()).for_each(|i| starts[i + 1] += starts[i]);
        let (mut next, mut edges) = (starts.clone(), vec![0; self.edges.len()]);
        for (e, [from, _]) in self.edges.iter().enumerate() {
            edges[next[*from as usize]] = e as u32;
            next[*from as usize] += 1;
        }
        (starts, edges)
    }
}

impl Component for Graph {
    fn kind(&self) -> &'static ComponentKind {
        &KIND
    }

    fn encode(&self, out: &mut Encoder<'_>) {
        self.nodes.encode_points(out);
        out.count(self.edges.len());
        out.u32s(self.edges.as_flattened());
        self.attributes.encode(out);
    }

    fn fingerprint(&self, print: &mut Fingerprint) {
        self.nodes.add_to(print);
        print.word(self.edges.len() as u64);
        self.edges.as_flattened().iter().for_each(|i| print.word(u64::from(*i)));
        self.attributes.fingerprint(print);
    }

    fn bytes(&self) -> usize {
        self.nodes.held() + size_of_val(&*self.edges) + self.attributes.bytes()
    }

    fn views(&self) -> &'static [(&'static str, Shape)] {
        &[("", Shape::Lines), ("nodes", Shape::Points)]
    }

    fn view(&self, name: &str) -> Option<View<'_>> {
        match name {
            "" => Some(View::Lines(Cow::Borrowed(self))),
            "nodes" => Some(View::Points(Cow::Borrowed(&self.nodes))),
            _ => None,
        }
    }
}
