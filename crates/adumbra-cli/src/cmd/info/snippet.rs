//! `info --snippet`: the lines that an app needs to use a file.

use std::path::Path;

use crate::args::SnippetArg;

/// Returns the lines for a shadow file.
pub(super) fn snippet(of: SnippetArg, file: &Path) -> String {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    match of {
        SnippetArg::Three => format!(
            "\
import {{ ShadowFileLoader }} from 'adumbra-three';
import {{ BakedShadowNode }} from 'adumbra-three/webgpu';

const file = await new ShadowFileLoader().loadAsync('{name}');
renderer.shadowMap.enabled = sun.castShadow = true;
sun.shadow.shadowNode = new BakedShadowNode(sun, {{ file }});

// With WebGLRenderer:
// import {{ attachBakedShadow }} from 'adumbra-three/webgl';
// attachBakedShadow(scene, sun, {{ file }});"
        ),
    }
}
