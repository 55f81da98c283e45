//! The window: turns winit's events into commands, and draws the picture and the panel to its surface.

mod input;

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use adumbra_compare::pictures::picture_of_rgba;
use adumbra_render::Gpu;
use adumbra_render::layers::PresentPass;
use adumbra_render::readback::read_texture;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::keyboard::ModifiersState;
use winit::window::{Window, WindowId};

use self::input::Pointer;
use crate::app::App;
use crate::error::{Result, ViewError};
use crate::event::{Event, EventSender};
use crate::messages::Say;
use crate::options::ViewOptions;
use crate::stage::is_fatal;
use crate::startup::Startup;
use crate::ui;

/// Interval at which a waiting view checks again.
const PULSE: Duration = Duration::from_millis(8);

/// Opens a window and returns when it is closed. `say` receives each message as a line.
///
/// # Errors
/// Returns [`ViewError::Window`] if there is no display, and other errors if the options, the first scene,
/// the script or the device are at fault.
pub fn run(options: ViewOptions, say: Say) -> Result<()> {
    let startup = Startup::new(options)?;
    let no_window = |e: winit::error::EventLoopError| ViewError::Window { reason: system_says(&e) };
    let events = EventLoop::<Event>::with_user_event().build().map_err(no_window)?;
    let proxy = events.create_proxy();
    let mut handler = Handler { startup: Some((startup, say)), proxy, open: None, ended: None };
    events.run_app(&mut handler).map_err(no_window)?;
    handler.ended.unwrap_or(Ok(()))
}

/// Returns winit's message without the location in winit's source that it starts with.
fn system_says(error: &dyn std::error::Error) -> String {
    let said = error.to_string();
    let what = said.strip_prefix("os error at ").and_then(|rest| rest.split_once(": "));
    what.map_or(said.as_str(), |(_, what)| what).trim_end_matches('.').to_owned()
}

struct Handler {
    startup: Option<(Startup, Say)>,
    proxy: EventLoopProxy<Event>,
    open: Option<Open>,
    ended: Option<Result<()>>,
}

/// State while the window is open.
struct Open {
    app: App,
    window: Arc<Window>,
    instance: wgpu::Instance,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    gpu: Gpu,
    present: PresentPass,
    egui: egui_winit::State,
    painter: egui_wgpu::Renderer,
    pointer: Pointer,
    held: BTreeSet<String>,
    modifiers: ModifiersState,
    last: Instant,
    /// Whether the view was active since the last tick. If not, the elapsed time is ignored.
    was_active: bool,
    /// When egui requests the next repaint.
    repaint_at: Option<Instant>,
}

/// The panel, ready to be drawn.
struct PanelDrawing {
    jobs: Vec<egui::ClippedPrimitive>,
    screen: egui_wgpu::ScreenDescriptor,
}

impl Open {
    fn new(
        startup: Startup,
        say: Say,
        events: &ActiveEventLoop,
        proxy: EventLoopProxy<Event>,
    ) -> Result<Self> {
        let no_window = |reason: String| ViewError::Window { reason };
        let options = &startup.options;
        let [width, height] = options.size;
        let attributes = Window::default_attributes()
            .with_title(format!("adumbra: {}", options.scene.display()))
            .with_inner_size(PhysicalSize::new(width, height));
        let window = Arc::new(events.create_window(attributes).map_err(|e| no_window(system_says(&e)))?);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let surface = instance.create_surface(window.clone()).map_err(|e| no_window(e.to_string()))?;
        let (gpu, adapter) = Gpu::request_for(&instance, &surface, &options.gpu)?;
        let capabilities = surface.get_capabilities(&adapter);
        let wanted = [wgpu::TextureFormat::Bgra8Unorm, wgpu::TextureFormat::Rgba8Unorm];
        let format = wanted.into_iter().find(|f| capabilities.formats.contains(f));
        let format = format.or(capabilities.formats.first().copied());
        let format = format.ok_or_else(|| no_window(format!("{} cannot draw on it", gpu.name())))?;
        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| no_window(format!("{} cannot draw on it", gpu.name())))?;
        config.format = format;
        config.present_mode = wgpu::PresentMode::AutoVsync;
        surface.configure(&gpu.device, &config);
        let context = egui::Context::default();
        let side = gpu.max_texture_side() as usize;
        let scale = window.scale_factor() as f32;
        let egui = egui_winit::State::new(
            context,
            egui::ViewportId::ROOT,
            &window,
            Some(scale),
            window.theme(),
            Some(side),
        );
        let painter = egui_wgpu::Renderer::new(&gpu.device, format, egui_wgpu::RendererOptions::default());
        let present = PresentPass::new(&gpu, format)?;
        let sender = EventSender::new(move |event| {
            // Sending fails only after the event loop, and thus the window, has closed.
            let _ = proxy.send_event(event);
        });
        let mut app = App::new(startup, gpu.clone(), sender, say);
        app.set_size([size.width, size.height]);
        Ok(Self {
            app,
            window,
            instance,
            surface,
            config,
            gpu,
            present,
            egui,
            painter,
            pointer: Pointer::default(),
            held: BTreeSet::new(),
            modifiers: ModifiersState::empty(),
            last: Instant::now(),
            was_active: false,
            repaint_at: None,
        })
    }

    fn resized(&mut self, size: PhysicalSize<u32>) {
        if size.width == 0 || size.height == 0 {
            return;
        }
        let most = self.gpu.max_texture_side();
        (self.config.width, self.config.height) = (size.width.min(most), size.height.min(most));
        self.surface.configure(&self.gpu.device, &self.config);
        self.app.set_size([self.config.width, self.config.height]);
        self.window.request_redraw();
    }

    /// Draws the scene if it changed, and the panel over it.
    fn redraw(&mut self) -> Result<()> {
        let input = self.egui.take_egui_input(&self.window);
        let context = self.egui.egui_ctx().clone();
        let mut commands = Vec::new();
        let output = context.run_ui(input, |ui| commands.extend(ui::show(ui, &self.app)));
        commands.iter().for_each(|command| self.app.command(command));
        self.egui.handle_platform_output(&self.window, output.platform_output);
        let delay = output.viewport_output.get(&egui::ViewportId::ROOT).map(|v| v.repaint_delay);
        self.repaint_at =
            delay.and_then(|d| Instant::now().checked_add(d)).filter(|_| delay < Some(PULSE * 1000));
        if self.app.needs_frame() {
            self.app.draw()?;
        }
        // Done even without a frame to draw to, because each texture update is delivered only once.
        for (id, deltas) in &output.textures_delta.set {
            deltas
                .iter()
                .for_each(|d| self.painter.update_texture(&self.gpu.device, &self.gpu.queue, *id, d));
        }
        let panel = PanelDrawing {
            jobs: context.tessellate(output.shapes, output.pixels_per_point),
            screen: egui_wgpu::ScreenDescriptor {
                size_in_pixels: [self.config.width, self.config.height],
                pixels_per_point: output.pixels_per_point,
            },
        };
        if let Some(path) = self.app.window_shot.take() {
            self.shoot(&path, &panel);
        }
        if let Some(frame) = self.frame()? {
            let mut encoder = self.gpu.encoder("view");
            self.paint(&mut encoder, &frame.texture.create_view(&Default::default()), &panel);
            self.gpu.queue.submit([encoder.finish()]);
            self.window.pre_present_notify();
            self.gpu.queue.present(frame);
        }
        output.textures_delta.free.iter().for_each(|id| self.painter.free_texture(id));
        match self.gpu.check() {
            Err(error) if is_fatal(&error) => Err(error.into()),
            Err(error) => {
                self.app.messages.error(error.to_string());
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }

    /// Returns the surface's next texture. `None` if no texture is available now; requests a redraw unless
    /// the window is hidden.
    fn frame(&mut self) -> Result<Option<wgpu::SurfaceTexture>> {
        match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(frame) | wgpu::CurrentSurfaceTexture::Suboptimal(frame) => {
                return Ok(Some(frame));
            }
            wgpu::CurrentSurfaceTexture::Outdated => self.surface.configure(&self.gpu.device, &self.config),
            wgpu::CurrentSurfaceTexture::Lost => {
                let made = self.instance.create_surface(self.window.clone());
                self.surface = made.map_err(|e| ViewError::Window { reason: e.to_string() })?;
                self.surface.configure(&self.gpu.device, &self.config);
            }
            wgpu::CurrentSurfaceTexture::Timeout | wgpu::CurrentSurfaceTexture::Validation => {}
            // The window is redrawn when it becomes visible.
            wgpu::CurrentSurfaceTexture::Occluded => return Ok(None),
        }
        self.window.request_redraw();
        Ok(None)
    }

    /// Draws the window a second time, into a texture, and writes that to a file.
    fn shoot(&mut self, path: &Path, panel: &PanelDrawing) {
        let [width, height] = panel.screen.size_in_pixels;
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let texture = self.gpu.texture("view::window", [width, height], self.config.format, usage);
        let mut encoder = self.gpu.encoder("view::window");
        self.paint(&mut encoder, &texture.create_view(&Default::default()), panel);
        self.gpu.queue.submit([encoder.finish()]);
        let written =
            read_texture(&self.gpu, &texture, 0, 0).map_err(|e| e.to_string()).and_then(|mut bytes| {
                if matches!(self.config.format.remove_srgb_suffix(), wgpu::TextureFormat::Bgra8Unorm) {
                    bytes.as_chunks_mut::<4>().0.iter_mut().for_each(|p| p.swap(0, 2));
                }
                self.app.write_picture(path, &picture_of_rgba([width, height], &bytes))
            });
        if let Err(what) = &written {
            self.app.messages.error(what.clone());
        }
        self.app.window_shot_done = Some(written);
    }

    /// Draws the picture, and the panel over it.
    fn paint(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        view: &wgpu::TextureView,
        PanelDrawing { jobs, screen }: &PanelDrawing,
    ) {
        let load = match &self.app.stage {
            Some(stage) => {
                stage.present(&self.present, encoder, view, &self.app.settings);
                wgpu::LoadOp::Load
            }
            None => wgpu::LoadOp::Clear(wgpu::Color::BLACK),
        };
        self.painter.update_buffers(&self.gpu.device, &self.gpu.queue, encoder, jobs, screen);
        let pass = Gpu::color_pass(encoder, "view::panel", view, load);
        self.painter.render(&mut pass.forget_lifetime(), jobs, screen);
    }

    /// Advances by the time since the last call.
    fn tick(&mut self) -> Result<()> {
        let now = Instant::now();
        let seconds = if self.was_active { (now - self.last).as_secs_f64() } else { 0.0 };
        self.last = now;
        let flight = self.flight();
        self.app.tick(seconds, flight)?;
        if let Some([width, height]) = self.app.resize.take()
            && let Some(size) = self.window.request_inner_size(PhysicalSize::new(width, height))
        {
            // A size that is not applied immediately arrives as an event.
            self.resized(size);
        }
        Ok(())
    }

    fn is_flying(&self) -> bool {
        !self.held.is_empty()
    }
}

impl Handler {
    fn end(&mut self, events: &ActiveEventLoop, with: Result<()>) {
        self.ended.get_or_insert(with);
        events.exit();
    }

    fn check(&mut self, events: &ActiveEventLoop, outcome: Result<()>) {
        match outcome {
            Err(error) => self.end(events, Err(error)),
            Ok(()) => {
                if let Some(app) = self.open.as_ref().map(|o| &o.app).filter(|app| app.quit) {
                    self.end(events, app.unfinished().map_or(Ok(()), Err));
                }
            }
        }
    }
}

impl ApplicationHandler<Event> for Handler {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let Some((startup, say)) = self.startup.take() else { return };
        match Open::new(startup, say, events, self.proxy.clone()) {
            Ok(open) => {
                open.window.request_redraw();
                self.open = Some(open);
            }
            Err(error) => self.end(events, Err(error)),
        }
    }

    fn user_event(&mut self, events: &ActiveEventLoop, event: Event) {
        let Some(open) = &mut self.open else { return };
        open.window.request_redraw();
        let outcome = open.app.receive(event);
        self.check(events, outcome);
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        let outcome = match &event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => {
                open.app.quit = true;
                Ok(())
            }
            WindowEvent::RedrawRequested => open.redraw(),
            _ => {
                let response = open.egui.on_window_event(&open.window, &event);
                open.event(&event, response.consumed);
                if response.repaint {
                    open.window.request_redraw();
                }
                Ok(())
            }
        };
        self.check(events, outcome);
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The surface must be dropped before the connection to the display.
        self.open = None;
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some(open) = &mut self.open else { return };
        let outcome = open.tick();
        let due = open.repaint_at.is_some_and(|at| at <= Instant::now()) || open.app.messages.has_gone();
        if open.app.needs_frame() || due {
            open.repaint_at = None;
            open.window.request_redraw();
        }
        let pulse = Instant::now() + PULSE;
        let calm = open.repaint_at.into_iter().chain(open.app.messages.until()).min();
        open.was_active = open.app.is_busy() || open.is_flying();
        let next = if open.was_active { Some(pulse) } else { calm };
        events.set_control_flow(next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
        self.check(events, outcome);
    }
}
