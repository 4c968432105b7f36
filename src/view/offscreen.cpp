#include "stylet/view/offscreen.hpp"

#include "stylet/base/errors.hpp"

#include <array>
#include <epoxy/egl.h>

namespace stylet {

struct OffscreenContext::Handles {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
};

OffscreenContext::OffscreenContext() : handles_(std::make_unique<Handles>()) {
  const auto need = [](bool good, const char* what) {
    if (!good) {
      throw Error(ExitCode::other,
                  std::string("pictures off the screen need EGL and OpenGL 3.3 (") + what +
                      "); Debian's libegl1 and libgl1-mesa-dri have them");
    }
  };
  need(epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"),
       "EGL_MESA_platform_surfaceless");
  handles_->display =
      eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  need(eglInitialize(handles_->display, nullptr, nullptr) == EGL_TRUE, "eglInitialize");
  need(eglBindAPI(EGL_OPENGL_API) == EGL_TRUE, "eglBindAPI");
  constexpr std::array<EGLint, 3> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint n_configs = 0;
  eglChooseConfig(handles_->display, wanted.data(), &config, 1, &n_configs);
  constexpr std::array<EGLint, 7> version{EGL_CONTEXT_MAJOR_VERSION,
                                          3,
                                          EGL_CONTEXT_MINOR_VERSION,
                                          3,
                                          EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                          EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                          EGL_NONE};
  handles_->context = eglCreateContext(handles_->display, n_configs > 0 ? config : nullptr,
                                       EGL_NO_CONTEXT, version.data());
  need(handles_->context != EGL_NO_CONTEXT, "eglCreateContext");
  need(eglMakeCurrent(handles_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, handles_->context) ==
           EGL_TRUE,
       "eglMakeCurrent");
}

OffscreenContext::~OffscreenContext() {
  eglMakeCurrent(handles_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(handles_->display, handles_->context);
  eglTerminate(handles_->display);
}

OffscreenTarget::OffscreenTarget(int width, int height) {
  glBindTexture(GL_TEXTURE_2D, texture_.get());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture_.get(), 0);
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw Error(ExitCode::other, "OpenGL: no picture of " + std::to_string(width) + " x " +
                                     std::to_string(height) + " pixels to draw into");
  }
}

}  // namespace stylet
