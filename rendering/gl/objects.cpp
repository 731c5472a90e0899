#include "rendering/gl/objects.h"

#include <fmt/format.h>

#include "core/error.h"
#include "rendering/gl/fullscreen_vert.h"

namespace wheatstone {
namespace {

GlShader compile(const std::string& name, GLenum stage, const std::string& source) {
  GlShader shader(glCreateShader(stage));
  const char* text = source.c_str();
  glShaderSource(shader.name(), 1, &text, nullptr);
  glCompileShader(shader.name());
  GLint ok = GL_FALSE;
  glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &ok);
  if (ok) return shader;
  GLint length = 0;
  glGetShaderiv(shader.name(), GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length > 0 ? length : 1), '\0');
  glGetShaderInfoLog(shader.name(), length, nullptr, log.data());
  throw GraphicsError(
      fmt::format("{} shader of '{}' does not compile: {}",
                  stage == GL_VERTEX_SHADER ? "vertex" : "fragment", name, log.c_str()),
      "report this with the driver's name");
}

}  // namespace

GlBuffer make_buffer() {
  GLuint n = 0;
  glCreateBuffers(1, &n);
  return GlBuffer(n);
}

GlTexture make_texture(GLenum target) {
  GLuint n = 0;
  glCreateTextures(target, 1, &n);
  return GlTexture(n);
}

GlFramebuffer make_framebuffer() {
  GLuint n = 0;
  glCreateFramebuffers(1, &n);
  return GlFramebuffer(n);
}

GlVertexArray make_vertex_array() {
  GLuint n = 0;
  glCreateVertexArrays(1, &n);
  return GlVertexArray(n);
}

GlProgram make_program(const std::string& name, const std::string& vertex_source,
                       const std::string& fragment_source) {
  return make_program(name, vertex_source, std::vector<std::string>{fragment_source});
}

GlProgram make_program(const std::string& name, const std::string& vertex_source,
                       const std::vector<std::string>& fragment_sources) {
  std::vector<GlShader> stages;
  stages.push_back(compile(name, GL_VERTEX_SHADER, vertex_source));
  for (const std::string& source : fragment_sources)
    stages.push_back(compile(name, GL_FRAGMENT_SHADER, source));
  GlProgram program(glCreateProgram());
  for (const GlShader& stage : stages) glAttachShader(program.name(), stage.name());
  glLinkProgram(program.name());
  for (const GlShader& stage : stages) glDetachShader(program.name(), stage.name());
  GLint ok = GL_FALSE;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &ok);
  if (ok) return program;
  GLint length = 0;
  glGetProgramiv(program.name(), GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length > 0 ? length : 1), '\0');
  glGetProgramInfoLog(program.name(), length, nullptr, log.data());
  throw GraphicsError(fmt::format("shader program '{}' does not link: {}", name, log.c_str()),
                      "report this with the driver's name");
}

GlProgram make_fullscreen_program(const std::string& name, const std::string& fragment_source) {
  return make_program(name, kFullscreenVert, fragment_source);
}

GlProgram make_fullscreen_program(const std::string& name,
                                  const std::vector<std::string>& fragment_sources) {
  return make_program(name, kFullscreenVert, fragment_sources);
}

void draw_fullscreen(const GlProgram& program, const GlVertexArray& vertices,
                     const GlFramebuffer& framebuffer, int width, int height) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  glViewport(0, 0, width, height);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glUseProgram(program.name());
  glBindVertexArray(vertices.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void require_no_gl_error(const std::string& what) {
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  throw GraphicsError(fmt::format("OpenGL error 0x{:04x} while {}", error, what),
                      error == GL_OUT_OF_MEMORY ? "use fewer or smaller images"
                                                : "report this with the driver's name");
}

}  // namespace wheatstone
