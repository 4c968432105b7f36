#include "stylet/view/tissue_drawing.hpp"

#include "stylet/view/colour_map.hpp"

#include <cmath>

namespace stylet {

namespace {

// Places of the picture are those of the undeformed mesh: the picture is deformed with it (paper, sec. III).
const char* const vertex_shader = R"(#version 330 core
layout(location = 0) in vec2 reference;
layout(location = 1) in vec2 displacement;
uniform vec2 centre;
uniform vec2 scale;
uniform vec2 picture_origin;
uniform vec2 picture_size;
out vec2 place;
void main() {
  vec2 at = (reference - picture_origin) / picture_size;
  place = vec2(at.x, 1.0 - at.y);
  gl_Position = vec4((reference + displacement - centre) * scale, 0.0, 1.0);
}
)";

const char* const fragment_shader = R"(#version 330 core
in vec2 place;
uniform sampler2D picture;
uniform samplerBuffer values;
uniform sampler2D map;
uniform float largest;   // 0: no colours
uniform bool has_picture;
uniform vec4 edge;       // alpha 0: no edges
out vec4 colour;
void main() {
  if (edge.a > 0.0) {
    colour = edge;
    return;
  }
  colour = vec4(has_picture ? texture(picture, place).rgb : vec3(0.32), 1.0);
  if (largest > 0.0) {
    float value = clamp(texelFetch(values, gl_PrimitiveID).r / largest, 0.0, 1.0);
    vec3 mapped = texture(map, vec2(value, 0.5)).rgb;
    colour.rgb = has_picture ? mix(colour.rgb, mapped, 0.6) : mapped;
  }
}
)";

enum Unit { picture_unit, values_unit, map_unit };

void set_filter(GLenum smaller) {
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, static_cast<GLint>(smaller));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

template <class T>
void fill(GLenum target, GLuint buffer, const std::vector<T>& values) {
  glBindBuffer(target, buffer);
  glBufferData(target, static_cast<GLsizeiptr>(values.size() * sizeof(T)), values.data(),
               GL_STREAM_DRAW);
}

void point_to(GLuint location, GLuint buffer) {
  glBindBuffer(GL_ARRAY_BUFFER, buffer);
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
}

}  // namespace

TissueDrawing::TissueDrawing(const Picture& picture) : place_(picture) {
  link_program(program_, vertex_shader, fragment_shader);
  glBindVertexArray(array_.get());
  point_to(0, reference_.get());
  point_to(1, displacement_.get());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, triangles_.get());
  glBindVertexArray(0);

  glBindTexture(GL_TEXTURE_2D, picture_.get());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  const bool grey = picture.channels == 1;
  glTexImage2D(GL_TEXTURE_2D, 0, grey ? GL_R8 : GL_RGB8, picture.width, picture.height, 0,
               grey ? GL_RED : GL_RGB, GL_UNSIGNED_BYTE, picture.bytes.data());
  if (grey) {
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_SWIZZLE_G, GL_RED);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_SWIZZLE_B, GL_RED);
  }
  glGenerateMipmap(GL_TEXTURE_2D);
  set_filter(GL_LINEAR_MIPMAP_LINEAR);

  glBindTexture(GL_TEXTURE_2D, map_.get());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, viridis.size(), 1, 0, GL_RGB, GL_UNSIGNED_BYTE,
               viridis.data());
  set_filter(GL_LINEAR);
  glBindBuffer(GL_TEXTURE_BUFFER, colours_.get());
  glBindTexture(GL_TEXTURE_BUFFER, colour_buffer_.get());
  glTexBuffer(GL_TEXTURE_BUFFER, GL_R32F, colours_.get());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  place_.bytes.clear();
}

void TissueDrawing::upload(const Frame& frame) {
  if (frame.number == uploaded_) return;
  uploaded_ = frame.number;
  fill(GL_ARRAY_BUFFER, reference_.get(), frame.reference);
  fill(GL_ARRAY_BUFFER, displacement_.get(), frame.displacement);
  fill(GL_ELEMENT_ARRAY_BUFFER, triangles_.get(), frame.triangles);
  fill(GL_TEXTURE_BUFFER, colours_.get(), frame.colour);
}

void TissueDrawing::draw(const Frame& frame,
                         const TissueLook& look,
                         const Camera& camera,
                         double pixel_ratio,
                         double window_height) {
  const Pane& pane = camera.pane();
  const auto pixels = [&](double length) {
    return static_cast<GLint>(std::lround(pixel_ratio * length));
  };
  glViewport(pixels(pane.left), pixels(window_height - pane.top - pane.height), pixels(pane.width),
             pixels(pane.height));
  glUseProgram(program_.get());
  glBindVertexArray(array_.get());
  upload(frame);
  const auto uniform = [&](const char* name) { return glGetUniformLocation(program_.get(), name); };
  const auto set = [&](const char* name, double x, double y) {
    glUniform2f(uniform(name), static_cast<float>(x), static_cast<float>(y));
  };
  const double scale = 2 / camera.metres_per_pixel();
  set("centre", camera.centre().x, camera.centre().y);
  set("scale", scale / pane.width, scale / pane.height);
  set("picture_origin", place_.origin.x, place_.origin.y);
  set("picture_size", place_.size.x, place_.size.y);
  glUniform1i(uniform("picture"), picture_unit);
  glUniform1i(uniform("values"), values_unit);
  glUniform1i(uniform("map"), map_unit);
  glUniform1i(uniform("has_picture"), look.picture ? 1 : 0);
  const bool coloured = frame.colouring != Colouring::none && look.largest > 0;
  glUniform1f(uniform("largest"), coloured ? static_cast<float>(look.largest) : 0.0F);
  glUniform4f(uniform("edge"), 0, 0, 0, 0);
  glActiveTexture(GL_TEXTURE0 + picture_unit);
  glBindTexture(GL_TEXTURE_2D, picture_.get());
  glActiveTexture(GL_TEXTURE0 + values_unit);
  glBindTexture(GL_TEXTURE_BUFFER, colour_buffer_.get());
  glActiveTexture(GL_TEXTURE0 + map_unit);
  glBindTexture(GL_TEXTURE_2D, map_.get());
  const auto count = static_cast<GLsizei>(frame.triangles.size());
  glDrawElements(GL_TRIANGLES, count, GL_UNSIGNED_INT, nullptr);
  if (look.edges) {
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    glUniform4f(uniform("edge"), 1, 1, 1, 0.28F);
    glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    glDrawElements(GL_TRIANGLES, count, GL_UNSIGNED_INT, nullptr);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  }
  glActiveTexture(GL_TEXTURE0);
  glBindVertexArray(0);
  glUseProgram(0);
}

}  // namespace stylet
