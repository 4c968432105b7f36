// Move-only owners of OpenGL's names; a context must be current where they are made and end.
#pragma once

#include <epoxy/gl.h>
#include <string>
#include <utility>

namespace stylet {

/// Make and Delete take a count and names, as glGenBuffers and glDeleteBuffers.
template <class Calls>
class GlName {
 public:
  GlName() { Calls::make(&name_); }
  GlName(const GlName&) = delete;
  GlName& operator=(const GlName&) = delete;
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~GlName() {
    if (name_ != 0) Calls::end(&name_);
  }
  [[nodiscard]] GLuint get() const { return name_; }

 private:
  GLuint name_ = 0;
};

struct BufferCalls {
  static void make(GLuint* name) { glGenBuffers(1, name); }
  static void end(const GLuint* name) { glDeleteBuffers(1, name); }
};
struct TextureCalls {
  static void make(GLuint* name) { glGenTextures(1, name); }
  static void end(const GLuint* name) { glDeleteTextures(1, name); }
};
struct ArrayCalls {
  static void make(GLuint* name) { glGenVertexArrays(1, name); }
  static void end(const GLuint* name) { glDeleteVertexArrays(1, name); }
};
struct FramebufferCalls {
  static void make(GLuint* name) { glGenFramebuffers(1, name); }
  static void end(const GLuint* name) { glDeleteFramebuffers(1, name); }
};
struct ProgramCalls {
  static void make(GLuint* name) { *name = glCreateProgram(); }
  static void end(const GLuint* name) { glDeleteProgram(*name); }
};
using GlBuffer = GlName<BufferCalls>;
using GlTexture = GlName<TextureCalls>;
using GlArray = GlName<ArrayCalls>;
using GlFramebuffer = GlName<FramebufferCalls>;
using GlProgram = GlName<ProgramCalls>;

/// Compiles and links. Throws Error with the compiler's words.
void link_program(const GlProgram& program, const std::string& vertex, const std::string& fragment);

}  // namespace stylet
