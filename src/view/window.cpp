#include "stylet/view/window.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/view/display.hpp"
#include "stylet/view/hand_input.hpp"
#include "stylet/view/places.hpp"
#include "stylet/view/png.hpp"

#include <GLFW/glfw3.h>
#include <algorithm>
#include <array>
#include <backends/imgui_impl_glfw.h>
#include <cmath>
#include <cstdio>
#include <imgui.h>

namespace stylet {

namespace {

/// GLFW from start to end, and its window.
class Glfw {
 public:
  explicit Glfw(const WindowOptions& options) {
    if (glfwInit() != GLFW_TRUE) fail("no window");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    window_ =
        glfwCreateWindow(options.width, options.height, options.title.c_str(), nullptr, nullptr);
    if (window_ == nullptr) {
      fail("no window with OpenGL 3.3");
    }
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
  }
  Glfw(const Glfw&) = delete;
  Glfw& operator=(const Glfw&) = delete;
  ~Glfw() { glfwTerminate(); }
  [[nodiscard]] GLFWwindow* window() const { return window_; }

 private:
  [[noreturn]] static void fail(const char* what) {
    const char* why = nullptr;
    glfwGetError(&why);
    const std::string text = why != nullptr ? why : "unknown cause";
    glfwTerminate();
    throw Error(ExitCode::other, std::string(what) + ": " + text +
                                     "; a display is needed, or --script, which draws without one");
  }
  GLFWwindow* window_ = nullptr;
};

/// Dear ImGui's part of GLFW: its callbacks call ours.
class Platform {
 public:
  explicit Platform(GLFWwindow* window) { ImGui_ImplGlfw_InitForOpenGL(window, true); }
  Platform(const Platform&) = delete;
  Platform& operator=(const Platform&) = delete;
  ~Platform() { ImGui_ImplGlfw_Shutdown(); }
};

class Window {
 public:
  Window(LiveSession& session, const WindowOptions& options)
      : session_(session), options_(options), glfw_(options), display_(session.picture()) {
    display_.planned = session.planned();
    GLFWwindow* window = glfw_.window();
    glfwSetWindowUserPointer(window, this);
    glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int mods) {
      of(w).button(button, action == GLFW_PRESS, mods);
    });
    glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
      of(w).moved({x, y});
    });
    glfwSetScrollCallback(window, [](GLFWwindow* w, double, double y) { of(w).wheel(y); });
    glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int mods) {
      if (action != GLFW_RELEASE) of(w).key(key, mods, action == GLFW_REPEAT);
    });
    platform_.emplace(window);
    const std::string renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    constexpr double by_processor = 1.0 / 30;  // s; the processor has the tissue to move, too
    if (renderer.find("llvmpipe") != std::string::npos) interval_ = by_processor;
    float scale = 1;
    glfwGetWindowContentScale(window, &scale, nullptr);
    display_.look.size = options.letters * scale;
  }

  WindowReport show() {
    const double start = clock_seconds();
    double last = start;
    while (glfwWindowShouldClose(glfw_.window()) == 0) {
      wait_for_next(last);
      const bool is_new = session_.take(frame_);
      if (is_new && first_at_ == 0) {
        first_at_ = frame_.made_at;
        first_time_ = frame_.time;
      }
      resize();
      const double now = clock_seconds();
      if (!ImGui::GetIO().WantCaptureKeyboard) input_.keys(held_keys(), frame_, now - last);
      if (const auto wanted = input_.take()) session_.want(*wanted);
      session_.colour(display_.look.colouring);
      draw();
      glfwSwapBuffers(glfw_.window());
      pace(now - last, is_new);
      last = now;
      if (options_.seconds && now - start > *options_.seconds) break;
    }
    report_.seconds = clock_seconds() - start;
    report_.real_time_factor = (frame_.time - first_time_) / (frame_.made_at - first_at_);
    report_.busy = frame_.pace.all_busy;
    report_.longest = frame_.pace.all_longest;
    return report_;
  }

 private:
  static Window& of(GLFWwindow* window) {
    return *static_cast<Window*>(glfwGetWindowUserPointer(window));
  }

  // Events are heard as they come; what is left of the time between two pictures is the physics'.
  void wait_for_next(double last) {
    glfwPollEvents();
    for (double left = 1; (left = last + interval_ - clock_seconds()) > 0;) {
      glfwWaitEventsTimeout(left);
    }
  }

  void resize() {
    int width = 1;
    int height = 1;
    glfwGetWindowSize(glfw_.window(), &width, &height);
    display_.resize(std::max(width, 1), std::max(height, 1));
    if (!fitted_ && frame_.number > 0) {
      display_.fit(frame_);
      fitted_ = true;
    }
  }

  [[nodiscard]] HeldKeys held_keys() const {
    const auto down = [&](int key) { return glfwGetKey(glfw_.window(), key) == GLFW_PRESS; };
    return {down(GLFW_KEY_LEFT), down(GLFW_KEY_RIGHT), down(GLFW_KEY_UP), down(GLFW_KEY_DOWN),
            down(GLFW_KEY_LEFT_SHIFT) || down(GLFW_KEY_RIGHT_SHIFT)};
  }

  void draw() {
    ImGui_ImplGlfw_NewFrame();
    const Wishes wishes = display_.draw(frame_, drawing_, paused_);
    for (const auto& order : wishes.orders) session_.order(order);
    if (wishes.pause) pause();
    if (saves_) save();
    saves_ = false;
  }

  void pace(double seconds, bool is_new) {
    constexpr double weight = 0.05;  // of a picture in the running mean
    constexpr double longest = 1;    // s; a hand that rests says nothing of the delay
    ++report_.frames;
    mean_ += weight * (seconds - mean_);
    drawing_.frames_per_second = mean_ > 0 ? 1 / mean_ : 0;
    const double delay = clock_seconds() - frame_.hand_stamp;
    if (!is_new || frame_.hand_stamp == stamp_ || delay > longest) return;
    stamp_ = frame_.hand_stamp;
    drawing_.delay += (drawing_.delay == 0 ? 1 : weight) * (delay - drawing_.delay);
    report_.delay += (delay - report_.delay) / static_cast<double>(++n_delays_);
  }

  void pause() {
    paused_ = !paused_;
    session_.pause(paused_);
  }

  void button(int button, bool pressed, int mods) {
    const bool on_tissue = !ImGui::GetIO().WantCaptureMouse && display_.camera.pane().holds(mouse_);
    const bool shift = (mods & GLFW_MOD_SHIFT) != 0;
    if (!pressed) {
      drags_ = false;
      if (button == GLFW_MOUSE_BUTTON_LEFT) input_.release(frame_);
      return;
    }
    if (!on_tissue) return;
    if (button == GLFW_MOUSE_BUTTON_MIDDLE || (button == GLFW_MOUSE_BUTTON_LEFT && shift)) {
      drags_ = true;
    } else if (button == GLFW_MOUSE_BUTTON_LEFT) {
      input_.press(mouse_, frame_, display_.camera);
    } else if (button == GLFW_MOUSE_BUTTON_RIGHT) {
      session_.order([](LiveRun& run) { run.seed(); });
    }
  }

  void moved(Pixel to) {
    const Pixel from = std::exchange(mouse_, to);
    if (drags_) {
      display_.camera.drag(from, to);
    } else if (input_.holds() ||
               (!ImGui::GetIO().WantCaptureMouse && display_.camera.pane().holds(to))) {
      input_.move(to, frame_, display_.camera);
    }
  }

  void wheel(double turns) {
    if (ImGui::GetIO().WantCaptureMouse) return;
    display_.camera.zoom(std::pow(1.15, turns), mouse_);
  }

  void key(int key, int mods, bool repeated) {
    if (ImGui::GetIO().WantTextInput) return;
    Look& look = display_.look;
    Camera& camera = display_.camera;
    const bool control = (mods & GLFW_MOD_CONTROL) != 0;
    constexpr double closer = 1.25;
    const double some = 40 * camera.metres_per_pixel();
    const bool plus = key == GLFW_KEY_EQUAL || key == GLFW_KEY_KP_ADD;
    const bool minus = key == GLFW_KEY_MINUS || key == GLFW_KEY_KP_SUBTRACT;
    if (plus || minus) {
      const double factor = plus ? closer : 1 / closer;
      if (control) {
        look.size = std::clamp(look.size * factor, 0.6, 4.0);
      } else {
        camera.zoom(factor, camera.middle());
      }
    }
    if (key == GLFW_KEY_W) camera.pan({0, some});
    if (key == GLFW_KEY_S) camera.pan({0, -some});
    if (key == GLFW_KEY_A) camera.pan({-some, 0});
    if (key == GLFW_KEY_D) camera.pan({some, 0});
    if (key == GLFW_KEY_LEFT_BRACKET || key == GLFW_KEY_RIGHT_BRACKET) {
      const double limit =
          frame_.speed_limit * (key == GLFW_KEY_RIGHT_BRACKET ? closer : 1 / closer);
      session_.order([limit](LiveRun& run) { run.change("hand.speed_limit", limit); });
    }
    if (repeated) return;  // the rest acts once
    if (key == GLFW_KEY_SPACE) session_.order([](LiveRun& run) { run.seed(); });
    if (key == GLFW_KEY_U) session_.order([](LiveRun& run) { run.undo(); });
    if (key == GLFW_KEY_R) session_.order([](LiveRun& run) { run.restart(); });
    if (key == GLFW_KEY_M) {
      constexpr std::array methods{"implicit", "quasi_static", "explicit"};
      const auto* now = std::ranges::find(methods, frame_.method);
      const std::string next = methods[static_cast<std::size_t>(now - methods.begin() + 1) % 3];
      session_.order([next](LiveRun& run) { run.choose_method(next); });
    }
    if (key == GLFW_KEY_P) pause();
    if (key == GLFW_KEY_F) display_.fit(frame_);
    if (key == GLFW_KEY_C)
      look.colouring = static_cast<Colouring>((static_cast<int>(look.colouring) + 1) % 3);
    if (key == GLFW_KEY_T) look.picture = !look.picture;
    if (key == GLFW_KEY_G) look.edges = !look.edges;
    if (key == GLFW_KEY_K) look.contacts = !look.contacts;
    if (key == GLFW_KEY_B) look.panel = !look.panel;
    if (key == GLFW_KEY_H || key == GLFW_KEY_F1) look.help = !look.help;
    if (key == GLFW_KEY_X) saves_ = true;
  }

  void save() {
    int width = 0;
    int height = 0;
    glfwGetFramebufferSize(glfw_.window(), &width, &height);
    const std::string name = "stylet-" + std::to_string(++n_saved_);
    save_framebuffer(name + ".png", width, height);
    write_places(name + ".json", frame_, display_.camera);
    std::printf("%s.png, %s.json\n", name.c_str(), name.c_str());
    std::fflush(stdout);
  }

  LiveSession& session_;
  WindowOptions options_;
  Glfw glfw_;
  Interface interface_;
  std::optional<Platform> platform_;
  Display display_;
  HandInput input_;
  Frame frame_;
  DrawingPace drawing_;
  WindowReport report_;
  Pixel mouse_;
  bool drags_ = false;
  bool paused_ = false;
  bool fitted_ = false;
  bool saves_ = false;
  int n_saved_ = 0;
  double interval_ = 1.0 / 60;  ///< s, the least between pictures
  double mean_ = 0;             ///< s between pictures
  double stamp_ = 0;
  long n_delays_ = 0;
  double first_at_ = 0;    ///< s of the clock, of the first frame
  double first_time_ = 0;  ///< s, simulated
};

}  // namespace

WindowReport show_window(LiveSession& session, const WindowOptions& options) {
  return Window(session, options).show();
}

}  // namespace stylet
