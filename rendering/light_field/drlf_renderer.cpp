#include "rendering/light_field/drlf_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "rendering/light_field/drlf_frag.h"

namespace wheatstone {
namespace {

constexpr std::int64_t kMaxFloatBytes = std::int64_t{1} << 30;
constexpr double kMaxHalf = 65504;

// std430 layouts of drlf.frag.
struct GpuCamera {
  std::array<float, 4> row[3];
  std::array<float, 4> st;
};
struct GpuCell {
  std::array<float, 4> a[3];
  std::array<std::int32_t, 4> cameras;
};
static_assert(sizeof(GpuCamera) == 64 && sizeof(GpuCell) == 64);

std::array<float, 4> to_float4(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), 0};
}

void set_vec3(GLint location, const Eigen::Vector3d& v) {
  const auto f = to_float4(v);
  glUniform3f(location, f[0], f[1], f[2]);
}

float peak(std::span<const LightFieldView> views) {
  double out = 0;
  for (const LightFieldView& view : views) {
    double largest = 0;
    cv::minMaxLoc(view.light_cd_m2.pixels.reshape(1), nullptr, &largest);
    out = std::max(out, largest);
  }
  return static_cast<float>(out);
}

}  // namespace

DrlfRenderer::DrlfRenderer(OffscreenContext& context, std::span<const LightFieldView> views)
    : context_(context), views_(views.begin(), views.end()), mesh_(views) {
  for (const LightFieldView& view : views)
    if (view.light_cd_m2.empty())
      throw ArgumentError(fmt::format("view '{}' has no picture", view.name),
                          "give views of at least 1x1 pixel");
  context_.make_current();
  program_ = make_fullscreen_program("drlf", kDrlfFrag);
  vertices_ = make_vertex_array();
  framebuffer_ = make_framebuffer();
  cameras_ = make_buffer();
  upload_views(views);
  upload_cells();
}

DrlfRenderer::~DrlfRenderer() {
  try {
    context_.make_current();
  } catch (const GraphicsError&) {
    // Held by another thread: the objects die with the context.
  }
}

void DrlfRenderer::upload_views(std::span<const LightFieldView> views) {
  int width = 0, height = 0;  // of a layer, which holds any of the views
  for (const LightFieldView& view : views) {
    width = std::max(width, view.light_cd_m2.width());
    height = std::max(height, view.light_cd_m2.height());
  }
  const int count = static_cast<int>(views.size());
  GLint max_size = 0, max_layers = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &max_size);
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &max_layers);
  if (std::max(width, height) > max_size || count > max_layers)
    throw GraphicsError(fmt::format("{} views of {}x{} exceed this GPU's {} layers of {} px", count,
                                    width, height, max_layers, max_size),
                        "use fewer or smaller views, or the CPU renderer");
  const bool half = std::int64_t{16} * width * height * count > kMaxFloatBytes;
  if (half) light_scale_ = std::min(1.0, kMaxHalf / std::max(peak(views), 1.0f));
  images_ = make_texture(GL_TEXTURE_2D_ARRAY);
  const GLuint name = images_.name();
  glTextureStorage3D(name, 1, half ? GL_RGBA16F : GL_RGBA32F, width, height, count);
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  for (int i = 0; i < count; ++i) {
    cv::Mat pixels = views[i].light_cd_m2.pixels;
    if (light_scale_ != 1) pixels = pixels * light_scale_;
    if (!pixels.isContinuous()) pixels = pixels.clone();
    glTextureSubImage3D(name, 0, 0, 0, i, pixels.cols, pixels.rows, 1, GL_RGB, GL_FLOAT,
                        pixels.data);
  }
  require_no_gl_error("uploading the light field");
}

void DrlfRenderer::upload_cells() {
  std::vector<GpuCell> cells;
  for (const CameraCell& cell : mesh_.cells()) {
    GpuCell out{};
    for (int k = 0; k < 3; ++k) {
      out.a[k] = to_float4(cell.a[k]);
      out.cameras[k] = cell.cameras[k];
    }
    out.cameras[3] = cell.camera_count;
    cells.push_back(out);
  }
  cells_ = make_buffer();
  glNamedBufferStorage(cells_.name(), static_cast<GLsizeiptr>(cells.size() * sizeof(GpuCell)),
                       cells.data(), 0);
  require_no_gl_error("uploading the camera mesh");
}

void DrlfRenderer::require_target(int width, int height) {
  if (width == target_width_ && height == target_height_) return;
  GLint max_size = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &max_size);
  if (std::max(width, height) > max_size)
    throw GraphicsError(
        fmt::format("a picture of {}x{} exceeds this GPU's {} px", width, height, max_size),
        "render a smaller picture or use the CPU renderer");
  target_width_ = target_height_ = 0;
  target_ = make_texture(GL_TEXTURE_2D);
  glTextureStorage2D(target_.name(), 1, GL_RGBA32F, width, height);
  glNamedFramebufferTexture(framebuffer_.name(), GL_COLOR_ATTACHMENT0, target_.name(), 0);
  if (glCheckNamedFramebufferStatus(framebuffer_.name(), GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw GraphicsError("this driver cannot draw into 32-bit float pictures",
                        "use another driver or the CPU renderer");
  require_no_gl_error("making the picture");
  target_width_ = width;
  target_height_ = height;
}

DrlfResult DrlfRenderer::render(const VirtualCamera& camera, const DrlfOptions& options) {
  const DrlfGeometry geometry = make_drlf_geometry(views_, mesh_, camera, options);
  context_.make_current();
  require_target(camera.width, camera.height);

  std::vector<GpuCamera> cameras(views_.size());
  for (std::size_t i = 0; i < views_.size(); ++i) {
    for (int r = 0; r < 3; ++r)
      cameras[i].row[r] = to_float4(geometry.H_data_virtual[i].row(r).transpose());
    const Eigen::Vector2d& st = mesh_.positions_mm()[i];
    cameras[i].st = {static_cast<float>(st.x()), static_cast<float>(st.y()),
                     static_cast<float>(views_[i].light_cd_m2.width()),
                     static_cast<float>(views_[i].light_cd_m2.height())};
  }
  glNamedBufferData(cameras_.name(), static_cast<GLsizeiptr>(cameras.size() * sizeof(GpuCamera)),
                    cameras.data(), GL_STREAM_DRAW);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, cameras_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, cells_.name());
  glBindTextureUnit(0, images_.name());

  // Locations as in drlf.frag.
  glUseProgram(program_.name());
  for (int r = 0; r < 3; ++r) set_vec3(r, geometry.H_aperture_virtual.row(r).transpose());
  set_vec3(3, geometry.inverse_depth_row);
  glUniform1i(4, static_cast<GLint>(options.aperture));
  glUniform1i(5, static_cast<GLint>(views_.size()));
  glUniform1i(6, static_cast<GLint>(mesh_.cells().size()));
  glUniform1f(7, static_cast<float>(options.gaussian_sigma_mm));
  glUniform1f(8, static_cast<float>(options.feather_px));
  glUniform1f(9, static_cast<float>(light_scale_));
  draw_fullscreen(program_, vertices_, framebuffer_, camera.width, camera.height);

  cv::Mat4f rgba(camera.height, camera.width);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glGetTextureImage(target_.name(), 0, GL_RGBA, GL_FLOAT,
                    static_cast<GLsizei>(rgba.total() * rgba.elemSize()), rgba.data);
  require_no_gl_error("rendering the light field");
  DrlfResult out{RgbImage(camera.width, camera.height), ScalarImage(camera.width, camera.height)};
  for (int j = 0; j < camera.height; ++j)
    for (int i = 0; i < camera.width; ++i) {
      const cv::Vec4f& p = rgba(j, i);
      out.light_cd_m2.pixels(j, i) = {p[0], p[1], p[2]};
      out.coverage.pixels(j, i) = p[3];
    }
  return out;
}

}  // namespace wheatstone
