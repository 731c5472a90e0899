#pragma once
// An OpenGL 4.5 core context without window or display server, through EGL.
//
// Rows: this is the one place where OpenCV's and OpenGL's pixels meet. Image row 0 is uploaded as
// the first texture row, and framebuffer row 0 is read back as image row 0; nothing is flipped.
// So gl_FragCoord.xy - 0.5 is the OpenCV pixel (the centre of the first pixel is (0, 0)), and the
// texture coordinate of OpenCV pixel p in an image of `size` pixels is (p + 0.5) / size.

#include <string>

namespace wheatstone {

/// Owns one context. GL objects (gl/objects.h) must die before it, while it is current.
/// Threads: one at a time; call make_current() after changing threads or contexts.
class OffscreenContext {
 public:
  /// Tries Mesa's surfaceless platform, then the EGL devices, then the default display; the new
  /// context is current. Errors: GraphicsError with what was tried and the remedy.
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

  /// Errors: GraphicsError, e.g. when the context is current in another thread.
  void make_current();

  const std::string& renderer() const { return renderer_; }  // GL_RENDERER
  const std::string& version() const { return version_; }    // GL_VERSION

 private:
  void release() noexcept;

  void* display_ = nullptr;  // EGLDisplay; shared by the process, so it is never terminated
  void* context_ = nullptr;  // EGLContext
  std::string renderer_, version_;
};

}  // namespace wheatstone
