use adumbra::bake::Size;
use adumbra::light::Sun;
use adumbra::scene::{self, LoadOptions};
use adumbra::tree::*;
use std::sync::atomic::AtomicBool;
#[test]
fn scratch() {
    for name in ["zdm2.glb", "kaykit_city_21.glb"] {
        let scene = scene::load(
            std::path::Path::new(&format!("/work/shared/scenes/{name}")),
            &LoadOptions::default(),
        )
        .unwrap();
        for depth in [8, 9, 10, 11] {
            let mut o = TreeOptions::new(
                Sun::from_direction([0.5, 0.8, 0.35]).unwrap(),
                Size::Resolution(1 << depth),
            );
            let p = PreparedTree::new(&scene, &o).unwrap();
            let mut last: Option<VoxelTree> = None;
            for (prune, builder, reduction) in [
                (true, Builder::Recursive, Reduction::Hash),
                (true, Builder::Recursive, Reduction::TreeHash),
                (true, Builder::Recursive, Reduction::Sort),
                (false, Builder::Recursive, Reduction::Hash),
                (false, Builder::Iterative, Reduction::Hash),
                (false, Builder::Pooled, Reduction::Hash),
            ] {
                if !prune && depth > 9 {
                    continue;
                }
                o.prune = prune;
                o.builder = builder;
                o.reduction = reduction;
                let b = p.build(&o, &AtomicBool::new(false)).unwrap();
                println!(
                    "{name} {depth} {prune} {builder:?} {reduction:?}: bytes {} {:?}",
                    b.tree.bytes(),
                    b.report
                );
                if let Some(l) = &last {
                    assert!(*l == b.tree, "differs");
                }
                last = Some(b.tree);
            }
        }
    }
}
