#include "stylet/view/gl.hpp"

#include "stylet/base/errors.hpp"

#include <array>

namespace stylet {

namespace {

void compile(GLuint program, GLenum kind, const std::string& text) {
  const GLuint shader = glCreateShader(kind);
  const char* source = text.c_str();
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  GLint good = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  std::array<char, 1024> log{};
  glGetShaderInfoLog(shader, log.size(), nullptr, log.data());
  glAttachShader(program, shader);
  glDeleteShader(shader);  // with the program
  if (good == 0) throw Error(ExitCode::other, std::string("OpenGL: a shader: ") + log.data());
}

}  // namespace

void link_program(const GlProgram& program,
                  const std::string& vertex,
                  const std::string& fragment) {
  compile(program.get(), GL_VERTEX_SHADER, vertex);
  compile(program.get(), GL_FRAGMENT_SHADER, fragment);
  glLinkProgram(program.get());
  GLint good = 0;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &good);
  if (good != 0) return;
  std::array<char, 1024> log{};
  glGetProgramInfoLog(program.get(), log.size(), nullptr, log.data());
  throw Error(ExitCode::other, std::string("OpenGL: a program: ") + log.data());
}

}  // namespace stylet
