#include "sim_hil/plant/renderer.hpp"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <mutex>
#include <vector>

#include "sim_hil/mujoco/room.hpp"
#include "sim_hil/plant/pixels.hpp"
#include "sim_hil/plant/textures.hpp"
#include "sim_hil/worlds/vec.hpp"

namespace sinew::plant {
namespace {

// The three calls and values of OpenGL that MuJoCo does not wrap (specification 4.6, chapters 18.2 and 22.2).
using ReadPixels = void (*)(int x, int y, int width, int height, unsigned format, unsigned type, void* data);
using BindFramebuffer = void (*)(unsigned target, unsigned framebuffer);
using GetString = const unsigned char* (*)(unsigned name);
constexpr unsigned kReadFramebuffer = 0x8CA8, kRgba = 0x1908, kUnsignedByte = 0x1401, kRendererName = 0x1F01;

constexpr double kNear = 0.02, kFar = 16.0;  // unless the room says otherwise, by <custom><numeric name="near_m" .../>

template <class F>
F gl_function(const char* name) {
  return reinterpret_cast<F>(eglGetProcAddress(name));
}

/// An OpenGL context without any surface, current on the creating thread.
class GlContext {
 public:
  hal::Status open(std::string& why) {
    // At these sizes one drawing thread is as fast as several, and takes no core from the control threads.
    setenv("LP_NUM_THREADS", "0", 0);
    setenv("GALLIUM_DRIVER", "llvmpipe", 0);
    setenv("LIBGL_ALWAYS_SOFTWARE", "1", 0);
    setenv("EGL_PLATFORM", "surfaceless", 0);
    display_ = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
    if (display_ == EGL_NO_DISPLAY) return fail("eglGetPlatformDisplay(surfaceless)", why);
    if (!eglInitialize(display_, nullptr, nullptr)) return fail("eglInitialize", why);
    if (!eglBindAPI(EGL_OPENGL_API)) return fail("eglBindAPI(OpenGL)", why);
    constexpr EGLint kWanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (!eglChooseConfig(display_, kWanted, &config, 1, &count) || count == 0) config = nullptr;
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, nullptr);
    if (context_ == EGL_NO_CONTEXT) return fail("eglCreateContext", why);
    if (!eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_)) return fail("eglMakeCurrent", why);
    return {};
  }
  ~GlContext() {
    if (context_ == EGL_NO_CONTEXT) return;
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
    eglReleaseThread();
  }

 private:
  static hal::Status fail(const char* call, std::string& why) {
    const EGLint code = eglGetError();
    why = std::string(call) + " failed with EGL error " + std::to_string(code);
    return hal::Error{hal::Errc::not_supported, "plant renderer", code};
  }
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

void set(float* out, const msg::Vec3& v) {
  out[0] = static_cast<float>(v.x), out[1] = static_cast<float>(v.y), out[2] = static_cast<float>(v.z);
}

}  // namespace

struct Renderer::Impl {
  ~Impl() {
    if (drawn) mjr_freeContext(&context);
    mjv_freeScene(&scene);
  }

  hal::Status open(const Options& o, std::string& why);
  bool draws_textures();
  void look(const msg::Vec3& eye, const msg::Vec3& forward, const msg::Vec3& up, double half_height_per_depth);
  void draw();
  void update();
  double number_of(const char* name, double otherwise) const {
    const int id = mj_name2id(model.get(), mjOBJ_NUMERIC, name);
    return id < 0 ? otherwise : model->numeric_data[model->numeric_adr[id]];
  }
  void show(const char* material, bool on) {
    float* alpha = model->mat_rgba + 4 * mj_name2id(model.get(), mjOBJ_MATERIAL, material) + 3;
    if (!on)
      *alpha = 0;
    else if (*alpha == 0)
      *alpha = material == std::string_view("swept") ? 0.34f : 1.0f;
  }

  Options options;
  GlContext gl;
  ModelPtr model;
  DataPtr data;
  mjvScene scene{};
  mjvOption visible{};
  mjrContext context{};
  bool drawn = false;
  double near_m = kNear, far_m = kFar;
  ReadPixels read_pixels = nullptr;
  BindFramebuffer bind_framebuffer = nullptr;
  std::vector<std::uint8_t> rgbx;
  std::string backend;
};

hal::Status Renderer::Impl::open(const Options& o, std::string& why) {
  options = o;
  if (hal::Status s = gl.open(why); !s) return s;
  read_pixels = gl_function<ReadPixels>("glReadPixels");
  bind_framebuffer = gl_function<BindFramebuffer>("glBindFramebuffer");
  const auto get_string = gl_function<GetString>("glGetString");
  if (!read_pixels || !bind_framebuffer || !get_string) {
    why = "OpenGL functions are missing";
    return hal::Error{hal::Errc::not_supported, "plant renderer"};
  }
  if (const unsigned char* name = get_string(kRendererName)) backend = reinterpret_cast<const char*>(name);

  auto loaded = load_room(o.room_xml, RoomUse::pictures, o.robots);
  if (!loaded) return loaded.error();
  model = std::move(*loaded);
  paint_room(*model);
  near_m = number_of("near_m", kNear);
  far_m = number_of("far_m", kFar);
  model->vis.global.offwidth = static_cast<int>(o.width);
  model->vis.global.offheight = static_cast<int>(o.height);
  model->vis.quality.offsamples = o.picture ? 4 : 0;
  if (!o.picture) model->vis.quality.shadowsize = 0;  // no map of the lights: 64 MB less
  data.reset(mj_makeData(model.get()));
  mj_forward(model.get(), data.get());

  mjv_defaultScene(&scene);
  constexpr int kMadeUp = 50;  // geoms that MuJoCo adds to those of the model
  mjv_makeScene(model.get(), &scene, std::max(200 * static_cast<int>(o.robots), model->ngeom + kMadeUp));
  scene.flags[mjRND_SHADOW] = o.picture;
  scene.flags[mjRND_REFLECTION] = scene.flags[mjRND_FOG] = 0;
  scene.flags[mjRND_SKYBOX] = std::count(model->tex_type, model->tex_type + model->ntex, int{mjTEXTURE_SKYBOX}) > 0;
  mjv_defaultOption(&visible);
  for (int g = 0; g < mjNGROUP; ++g) visible.geomgroup[g] = g == 0 || (g == 1 && (o.picture || o.robots > 1));
  update();

  mjr_defaultContext(&context);
  mjr_makeContext(model.get(), &context, mjFONTSCALE_50);
  drawn = true;
  mjr_setBuffer(mjFB_OFFSCREEN, &context);
  if (context.currentBuffer != mjFB_OFFSCREEN) {
    why = "OpenGL gives no offscreen buffer";
    return hal::Error{hal::Errc::not_supported, "plant renderer"};
  }
  rgbx.resize(std::size_t{o.width} * o.height * 4);
  if (!draws_textures()) {
    why = "OpenGL (" + backend + ") draws surfaces without their textures";
    return hal::Error{hal::Errc::not_supported, "plant renderer"};
  }
  return {};
}

/// Looks at an empty piece of floor, which both rooms have. Over the grey floor that Mesa's llvmpipe draws for 32-bit
/// Arm in qemu-user, a robot would fly and find no pad.
bool Renderer::Impl::draws_textures() {
  look({1.2, -1.2, 0.5}, {0, 0, -1}, {1, 0, 0}, 0.5 / kFocalPerHeight);
  draw();
  return has_pattern(rgbx.data(), options.width, options.height);
}

void Renderer::Impl::look(const msg::Vec3& eye, const msg::Vec3& forward, const msg::Vec3& up,
                          double half_height_per_depth) {
  mjvGLCamera& c = scene.camera[0];
  set(c.pos, eye);
  set(c.forward, forward);
  set(c.up, up);
  c.frustum_center = 0;
  c.frustum_near = static_cast<float>(near_m);
  c.frustum_far = static_cast<float>(far_m);
  c.frustum_top = static_cast<float>(near_m * half_height_per_depth);
  c.frustum_bottom = -c.frustum_top;
  scene.camera[1] = c;  // MuJoCo draws with the mean of both
}

/// Updates what is drawn from the positions in `data`.
void Renderer::Impl::update() {
  mjvCamera anywhere;
  mjv_defaultCamera(&anywhere);
  mjv_updateScene(model.get(), data.get(), &visible, nullptr, &anywhere, mjCAT_ALL, &scene);
}

void Renderer::Impl::draw() {
  // Mesa 22.3's llvmpipe crashes now and then when two contexts of a process draw at the same time.
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  const mjrRect all{0, 0, static_cast<int>(options.width), static_cast<int>(options.height)};
  mjr_render(all, &scene, &context);
  if (options.picture) {  // resolves the samples
    std::vector<std::uint8_t> rgb(std::size_t{options.width} * options.height * 3);
    mjr_readPixels(rgb.data(), nullptr, all, &context);
    for (std::size_t i = 0; i < rgb.size() / 3; ++i)
      for (std::size_t c = 0; c < 3; ++c) rgbx[4 * i + c] = rgb[3 * i + c];
    return;
  }
  bind_framebuffer(kReadFramebuffer, context.offFBO);
  read_pixels(0, 0, all.width, all.height, kRgba, kUnsignedByte, rgbx.data());
}

Renderer::Renderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Renderer::~Renderer() = default;
const std::string& Renderer::backend() const { return impl_->backend; }

hal::Result<std::unique_ptr<Renderer>> Renderer::create(const Options& options, std::string& why) {
  auto impl = std::make_unique<Impl>();
  if (hal::Status s = impl->open(options, why); !s) return s.error();
  return std::unique_ptr<Renderer>(new Renderer(std::move(impl)));
}

void Renderer::place(const Scene& scene) {
  const auto bodies = std::min(scene.bodies, static_cast<std::size_t>(impl_->model->nmocap));
  const auto vehicles = std::min(scene.vehicles, static_cast<std::size_t>(impl_->model->nq) / 7);
  if (vehicles == 0 && bodies == 0) return;
  for (std::size_t i = 0; i < vehicles; ++i) {
    const Pose& v = scene.vehicle[i];
    const double q[] = {v.p_world_m.x, v.p_world_m.y, v.p_world_m.z, v.q_world.w,
                        v.q_world.x,   v.q_world.y,   v.q_world.z};
    std::copy_n(q, 7, impl_->data->qpos + 7 * i);
  }
  if (vehicles > 0) {
    impl_->show("blade", !scene.rotors_turn);
    impl_->show("swept", scene.rotors_turn);
  }
  for (std::size_t b = 0; b < bodies; ++b) {
    const Pose& at = scene.body[b];
    const double p[] = {at.p_world_m.x, at.p_world_m.y, at.p_world_m.z};
    const double q[] = {at.q_world.w, at.q_world.x, at.q_world.y, at.q_world.z};
    std::copy_n(p, 3, impl_->data->mocap_pos + 3 * b);
    std::copy_n(q, 4, impl_->data->mocap_quat + 4 * b);
  }
  mj_kinematics(impl_->model.get(), impl_->data.get());
  impl_->update();
}

void Renderer::camera_view(const CameraPose& pose, msg::PixelFormat format, std::uint8_t* out) {
  const Rotation r(pose.q_world_optical);
  impl_->look(pose.p_world_m, r.apply({0, 0, 1}), r.apply({0, -1, 0}), 0.5 / pose.focal_per_height);
  impl_->draw();
  convert_image(impl_->rgbx.data(), impl_->options.width, impl_->options.height, format, out);
}

void Renderer::outside_view(const msg::Vec3& eye_m, const msg::Vec3& target_m, std::uint8_t* out) {
  Impl& i = *impl_;
  msg::Vec3 f = sub(target_m, eye_m);
  f = scale(f, 1.0 / std::sqrt(f.x * f.x + f.y * f.y + f.z * f.z));
  const double level = std::sqrt(f.x * f.x + f.y * f.y);
  i.look(eye_m, f, {-f.z * f.x / level, -f.z * f.y / level, level}, 0.45);
  i.draw();
  convert_image(i.rgbx.data(), i.options.width, i.options.height, msg::PixelFormat::rgb8, out);
}

}  // namespace sinew::plant
