//! `adumbra export`: a shadow file as a web page fetches it.
//!
//! The copy is coded: a page decodes it piece by piece while it loads, and a server needs no setting for it.

use std::path::Path;

use adumbra::AtRest;
use adumbra_program::exit::{Code, Outcome};
use adumbra_program::output::{format_bytes, print_json};
use adumbra_program::say;
use schemars::JsonSchema;
use serde::Serialize;

use super::convert;
use crate::args::Export;

/// The file for a web page.
#[derive(Serialize, JsonSchema)]
pub(super) struct WebExported {
    /// The shadow file that was read.
    file: String,
    /// The copy that a page fetches.
    web: String,
    /// Bytes of the copy.
    web_bytes: u64,
}

pub(crate) fn run(args: &Export) -> Outcome {
    let web = &*args.web;
    let [_, web_bytes] = convert::store(&args.file, web, AtRest::Coded, &args.run)?;
    if args.run.json {
        print_json(&WebExported {
            file: args.file.display().to_string(),
            web: web.display().to_string(),
            web_bytes,
        })?;
    } else {
        say!("{}: {}", web.display(), format_bytes(web_bytes));
        say!("{}", lines_to_paste(web));
    }
    Ok(Code::Fine)
}

/// What a page needs, for three.js.
fn lines_to_paste(web: &Path) -> String {
    let name = web.file_name().unwrap_or_default().to_string_lossy();
    format!(
        "
In the page:

import {{ ShadowFileLoader }} from 'adumbra-three';
import {{ BakedShadowNode }} from 'adumbra-three/webgpu';

const file = await new ShadowFileLoader().loadAsync('{name}');
renderer.shadowMap.enabled = sun.castShadow = true;
sun.shadow.shadowNode = new BakedShadowNode(sun, {{ file }});

With WebGLRenderer:

import {{ attachBakedShadow }} from 'adumbra-three/webgl';
attachBakedShadow(scene, sun, file);"
    )
}
