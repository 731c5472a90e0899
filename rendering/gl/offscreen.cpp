#include "rendering/gl/offscreen.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <utility>
#include <vector>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr const char* kRemedy =
    "install a driver with OpenGL 4.5 and EGL (software: Debian's libegl1 and libgl1-mesa-dri), "
    "and "
    "check that EGL_PLATFORM and __EGL_VENDOR_LIBRARY_FILENAMES do not hide it";

EGLContext create_context(EGLDisplay display) {
  EGLint major = 0, minor = 0;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor)) return EGL_NO_CONTEXT;
  if (!epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context") ||
      !eglBindAPI(EGL_OPENGL_API))
    return EGL_NO_CONTEXT;
  // No surface is ever made, so any configuration that can draw OpenGL will do.
  const std::array<EGLint, 5> wanted = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0,
                                        EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglChooseConfig(display, wanted.data(), &config, 1, &count) || count < 1)
    return EGL_NO_CONTEXT;
  const std::array<EGLint, 7> attributes = {EGL_CONTEXT_MAJOR_VERSION,
                                            4,
                                            EGL_CONTEXT_MINOR_VERSION,
                                            5,
                                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                            EGL_NONE};
  return eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
}

/// Displays in the order of preference, each with its name for the error text.
std::vector<std::pair<std::string, EGLDisplay>> candidate_displays() {
  std::vector<std::pair<std::string, EGLDisplay>> out;
  const auto has = [](const char* extension) {
    return epoxy_has_egl_extension(EGL_NO_DISPLAY, extension);
  };
  if (has("EGL_EXT_platform_base")) {
    if (has("EGL_MESA_platform_surfaceless"))
      out.emplace_back("surfaceless", eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA,
                                                               EGL_DEFAULT_DISPLAY, nullptr));
    if (has("EGL_EXT_platform_device") &&
        (has("EGL_EXT_device_base") || has("EGL_EXT_device_enumeration"))) {
      std::array<EGLDeviceEXT, 16> devices{};
      EGLint count = 0;
      if (eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count))
        for (EGLint i = 0; i < count; ++i)
          out.emplace_back("device " + std::to_string(i),
                           eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
    }
  }
  out.emplace_back("default display", eglGetDisplay(EGL_DEFAULT_DISPLAY));
  return out;
}

std::string gl_text(GLenum name) {
  const GLubyte* text = glGetString(name);
  return text ? reinterpret_cast<const char*>(text) : "unknown";
}

}  // namespace

OffscreenContext::OffscreenContext() {
  std::string tried;
  for (const auto& [name, display] : candidate_displays()) {
    tried += (tried.empty() ? "" : ", ") + name;
    const EGLContext context = create_context(display);
    if (context == EGL_NO_CONTEXT) continue;
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
      eglDestroyContext(display, context);
      continue;
    }
    display_ = display;
    context_ = context;
    renderer_ = gl_text(GL_RENDERER);
    version_ = gl_text(GL_VERSION);
    return;
  }
  throw GraphicsError("no OpenGL 4.5 core context through EGL (tried " + tried + ")", kRemedy);
}

OffscreenContext::~OffscreenContext() {
  release();
}

void OffscreenContext::make_current() {
  if (eglGetCurrentContext() == context_) return;
  if (!eglBindAPI(EGL_OPENGL_API) ||
      !eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
    throw GraphicsError("the OpenGL context cannot be made current",
                        "use it from one thread at a time");
}

void OffscreenContext::release() noexcept {
  if (!context_) return;
  if (eglGetCurrentContext() == context_)
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
}

}  // namespace wheatstone
