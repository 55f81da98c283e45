//! Bakes that build a graph: plain, packed, or together with depths.

use std::sync::atomic::AtomicBool;

use adumbra::layout::depths::DepthTree;
use adumbra::layout::packed::PackedDag;
use adumbra::layout::plain::Dag;

use super::run::Run;
use crate::error::{Error, Result};
use crate::options::Builder;
use crate::pack::pack_paged;
use crate::plain::build::{self as plain_build, PlainBuffers};
use crate::plan::Plan;
use crate::sink::depths::DepthsSink;
use crate::sink::pair::Pair;
use crate::sink::runs::GraphSink;
use crate::store::{NodeState, NodeStore, PagedDag};
use crate::tally::Tally;

/// Builds the plain graph.
pub(crate) fn plain(
    plan: &Plan<'_>,
    tally: &Tally<'_, '_>,
    builder: Builder,
    cancel: &AtomicBool,
) -> Result<Dag> {
    let (store, columns) = build_graph(plan, tally, builder, cancel)?;
    finish_graph(store, plan, tally, &columns, 0)
}

/// Builds the packed graph. With a memory limit, the plain one is never whole in memory.
pub(crate) fn packed(
    plan: &Plan<'_>,
    tally: &Tally<'_, '_>,
    builder: Builder,
    cancel: &AtomicBool,
) -> Result<PackedDag> {
    let (store, columns) = build_graph(plan, tally, builder, cancel)?;
    let (numbered, mut held_bytes) = number_graph(store, plan, tally, &columns, 0)?;
    if plan.spill.is_none() {
        held_bytes += numbered.graph_bytes();
    }
    let make_room = |bytes| tally.check_end("packing the graph", held_bytes + bytes);
    let packed = pack_paged(numbered, make_room)?;
    plan.paged_bytes()?;
    Ok(packed)
}

/// Builds the graph and the depths of the same columns, which are computed once. Memory is that of both.
pub(crate) fn both(plan: &Plan<'_>, tally: &Tally<'_, '_>, cancel: &AtomicBool) -> Result<(Dag, DepthTree)> {
    let store = NodeStore::new(plan.spill.as_ref());
    let sink = Pair(
        GraphSink::new(&store, plan.tiles.grid.size[2]),
        DepthsSink::new(plan.tiles.root_level, true, plan.spill.as_ref()),
    );
    let held_bytes = || store.memory_bytes() + sink.1.memory_bytes();
    let finished_tile = || {
        check_room(&store)?;
        sink.1.check_room()?;
        tally.finished_tile("the graph and the depths so far", held_bytes(), store.graph_bytes())
    };
    let run = Run { plan, cancel, finished_tile: &finished_tile };
    let (runs, blocks): (Vec<_>, Vec<_>) = run.each_block(&sink, tally)?.into_iter().unzip();
    let kept_bytes = sink.1.memory_bytes();
    tally.check_end("numbering the depths", held_bytes() + sink.1.finish_bytes())?;
    let Pair(graph_sink, depths_sink) = sink;
    let roots = |runs| graph_sink.roots(runs, plan.tiles.root_level, plan.tiles.top_dims[2]);
    let columns: Vec<_> = runs.iter().map(roots).collect();
    let depths = depths_sink.finish(plan.tiles.grid.size, plan.tiles.root_level, blocks);
    let dag = finish_graph(store, plan, tally, &columns, kept_bytes + depths.bytes())?;
    Ok((dag, depths))
}

/// Builds the nodes of all root blocks. Also returns the roots of each block, nearest first.
fn build_graph(
    plan: &Plan<'_>,
    tally: &Tally<'_, '_>,
    builder: Builder,
    cancel: &AtomicBool,
) -> Result<(NodeStore, Vec<Vec<NodeState>>)> {
    let store = NodeStore::new(plan.spill.as_ref());
    let finished_tile = || -> Result<()> {
        check_room(&store)?;
        tally.finished_tile("the graph so far", store.memory_bytes(), store.graph_bytes())
    };
    let run = Run { plan, cancel, finished_tile: &finished_tile };
    let columns = match builder {
        Builder::Fast => {
            let sink = GraphSink::new(&store, plan.tiles.grid.size[2]);
            let blocks = run.each_block(&sink, tally)?;
            blocks
                .iter()
                .map(|block| sink.roots(block, plan.tiles.root_level, plan.tiles.top_dims[2]))
                .collect()
        }
        Builder::Plain => run.each_tile(|worker: &mut PlainBuffers, tile| {
            let rect = plan.tiles.rect(tile);
            tally.drew(u64::from(rect.width) * u64::from(rect.height));
            Ok(plain_build::build_root(&plan.tiles, plan.switch_limit(), tile, &store, worker))
        })?,
    };
    Ok((store, columns))
}

/// Checks that the graph has no more words than can be numbered.
fn check_room(store: &NodeStore) -> Result<()> {
    if store.is_full() { Err(Error::TooManyWords { what: "the graph" }) } else { Ok(()) }
}

/// Finishes the graph over the given roots, nearest first for each tile. `beside_bytes` are held in addition.
fn finish_graph(
    store: NodeStore,
    plan: &Plan<'_>,
    tally: &Tally<'_, '_>,
    columns: &[Vec<NodeState>],
    beside_bytes: u64,
) -> Result<Dag> {
    let (numbered, kept_bytes) = number_graph(store, plan, tally, columns, beside_bytes)?;
    if plan.spill.is_some() {
        tally.check_end("the finished graph", beside_bytes + kept_bytes + numbered.graph_bytes())?;
    }
    let dag = numbered.into_dag();
    plan.paged_bytes()?;
    Ok(dag)
}

/// Numbers the graph over the given roots, and leaves it in pages if there is a memory limit. Also returns the bytes of
/// what has been freed by then, because allocators rarely return it to the system.
fn number_graph(
    store: NodeStore,
    plan: &Plan<'_>,
    tally: &Tally<'_, '_>,
    columns: &[Vec<NodeState>],
    beside_bytes: u64,
) -> Result<(PagedDag, u64)> {
    let kept_bytes = store.memory_bytes();
    let copy_bytes = if plan.spill.is_some() { 0 } else { store.graph_bytes() };
    tally.check_end("numbering the graph", beside_bytes + kept_bytes + store.numbers_bytes() + copy_bytes)?;
    let top = top_grid(columns, plan.tiles.top_dims[2]);
    let numbered = store.number(plan.tiles.grid.size, plan.tiles.root_level, plan.tiles.top_dims, &top);
    plan.paged_bytes()?;
    Ok((numbered, kept_bytes))
}

/// Arranges the roots of each tile, nearest first, as one grid: x fastest, then y, then z.
fn top_grid(columns: &[Vec<NodeState>], depth: u32) -> Vec<NodeState> {
    (0..depth as usize).flat_map(|z| columns.iter().map(move |roots| roots[z])).collect()
}
