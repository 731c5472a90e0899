#pragma once
// Owning OpenGL objects. All need a current context when made and when destroyed.

#include <epoxy/gl.h>

#include <string>
#include <utility>
#include <vector>

namespace wheatstone {

/// A GL name that is deleted with its owner. Traits: destroy(GLuint).
template <class Traits>
class GlObject {
 public:
  GlObject() = default;
  explicit GlObject(GLuint name) : name_(name) {}
  ~GlObject() { reset(); }
  GlObject(GlObject&& o) noexcept : name_(std::exchange(o.name_, 0)) {}
  GlObject& operator=(GlObject&& o) noexcept {
    if (this != &o) {
      reset();
      name_ = std::exchange(o.name_, 0);
    }
    return *this;
  }
  GLuint name() const { return name_; }

 private:
  void reset() {
    if (name_) Traits::destroy(name_);
    name_ = 0;
  }
  GLuint name_ = 0;
};

struct GlBufferTraits {
  static void destroy(GLuint n) { glDeleteBuffers(1, &n); }
};
struct GlTextureTraits {
  static void destroy(GLuint n) { glDeleteTextures(1, &n); }
};
struct GlFramebufferTraits {
  static void destroy(GLuint n) { glDeleteFramebuffers(1, &n); }
};
struct GlVertexArrayTraits {
  static void destroy(GLuint n) { glDeleteVertexArrays(1, &n); }
};
struct GlShaderTraits {
  static void destroy(GLuint n) { glDeleteShader(n); }
};
struct GlProgramTraits {
  static void destroy(GLuint n) { glDeleteProgram(n); }
};
using GlBuffer = GlObject<GlBufferTraits>;
using GlTexture = GlObject<GlTextureTraits>;
using GlFramebuffer = GlObject<GlFramebufferTraits>;
using GlVertexArray = GlObject<GlVertexArrayTraits>;
using GlShader = GlObject<GlShaderTraits>;
using GlProgram = GlObject<GlProgramTraits>;

GlBuffer make_buffer();
GlTexture make_texture(GLenum target);  // GL_TEXTURE_2D, GL_TEXTURE_2D_ARRAY, ...
GlFramebuffer make_framebuffer();
GlVertexArray make_vertex_array();

/// Compiles and links two GLSL sources; `name` is for the error text.
/// Errors: GraphicsError with the driver's log.
GlProgram make_program(const std::string& name, const std::string& vertex_source,
                       const std::string& fragment_source);

/// The same with a fragment stage of several sources, which may call each other's functions.
GlProgram make_program(const std::string& name, const std::string& vertex_source,
                       const std::vector<std::string>& fragment_sources);

/// A program whose vertex stage covers the whole framebuffer: draw it with draw_fullscreen().
GlProgram make_fullscreen_program(const std::string& name, const std::string& fragment_source);
GlProgram make_fullscreen_program(const std::string& name,
                                  const std::vector<std::string>& fragment_sources);

/// Runs `program` once for every pixel of `framebuffer` (width x height).
void draw_fullscreen(const GlProgram&, const GlVertexArray&, const GlFramebuffer&, int width,
                     int height);

/// Throws GraphicsError naming `what` if OpenGL has recorded an error (out of memory included).
void require_no_gl_error(const std::string& what);

}  // namespace wheatstone
