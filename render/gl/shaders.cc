#include "render/gl/shaders.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/error.h"

namespace hpdm {
namespace {

/// Returns the driver's log as one line.
std::string OneLine(std::string log) {
  while (!log.empty() && (log.back() == '\n' || log.back() == '\0')) log.pop_back();
  std::replace(log.begin(), log.end(), '\n', ';');
  return log.empty() ? "the driver gives no reason" : log;
}

/// Compiles one stage and attaches it; the program keeps it alive.
void AttachStage(GLuint program, GLenum stage, const std::string& label,
                 const std::vector<const char*>& parts) {
  std::vector<const char*> sources = {"#version 330 core\n"};
  sources.insert(sources.end(), parts.begin(), parts.end());
  const GLuint shader = glCreateShader(stage);
  glShaderSource(shader, static_cast<GLsizei>(sources.size()), sources.data(), nullptr);
  glCompileShader(shader);
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  std::string log;
  if (compiled != GL_TRUE) {
    GLint length = 0;
    glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
    log.resize(static_cast<std::size_t>(std::max(length, 0)));
    glGetShaderInfoLog(shader, length, nullptr, log.data());
  }
  glAttachShader(program, shader);
  glDeleteShader(shader);
  if (compiled != GL_TRUE) {
    throw MachineError("shader " + label + " does not compile: " + OneLine(std::move(log)) +
                       "; update the OpenGL driver (3.3 core or newer) or run without pictures");
  }
}

}  // namespace

ShaderProgram::ShaderProgram(std::string name, const std::vector<const char*>& vertex_parts,
                             const std::vector<const char*>& fragment_parts,
                             const std::vector<const char*>& captured)
    : name_(std::move(name)) {
  AttachStage(program_.name(), GL_VERTEX_SHADER, name_ + " (vertex)", vertex_parts);
  if (!fragment_parts.empty()) {
    AttachStage(program_.name(), GL_FRAGMENT_SHADER, name_ + " (fragment)", fragment_parts);
  }
  if (!captured.empty()) {
    glTransformFeedbackVaryings(program_.name(), static_cast<GLsizei>(captured.size()),
                                captured.data(), GL_SEPARATE_ATTRIBS);
  }
  glLinkProgram(program_.name());
  GLint linked = GL_FALSE;
  glGetProgramiv(program_.name(), GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return;
  GLint length = 0;
  glGetProgramiv(program_.name(), GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(std::max(length, 0)), '\0');
  glGetProgramInfoLog(program_.name(), length, nullptr, log.data());
  throw MachineError("shader " + name_ + " does not link: " + OneLine(std::move(log)) +
                     "; update the OpenGL driver (3.3 core or newer) or run without pictures");
}

void ShaderProgram::Use() const { glUseProgram(program_.name()); }

int ShaderProgram::Uniform(const char* uniform) const {
  const GLint location = glGetUniformLocation(program_.name(), uniform);
  HPDM_CHECK(location >= 0);
  return location;
}

void ShaderProgram::BindBlock(const char* block, unsigned binding) const {
  const GLuint index = glGetUniformBlockIndex(program_.name(), block);
  HPDM_CHECK(index != GL_INVALID_INDEX);
  glUniformBlockBinding(program_.name(), index, binding);
}

void ShaderProgram::BindTexture(const char* sampler, int unit) const {
  Use();
  glUniform1i(Uniform(sampler), unit);
}

}  // namespace hpdm
