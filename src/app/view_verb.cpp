#include "stylet/app/verbs.hpp"
#include "stylet/base/errors.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/view/view.hpp"

#include <charconv>

namespace stylet {

namespace {

PictureSize size_of_text(const std::string& text) {
  constexpr int least = 64;  // pixels
  constexpr int most = 8192;
  PictureSize size;
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  if (width.ec == std::errc() && width.ptr != end && *width.ptr == 'x') {
    const auto height = std::from_chars(width.ptr + 1, end, size.height);
    const auto fits = [](int n) { return n >= least && n <= most; };
    if (height.ec == std::errc() && height.ptr == end && fits(size.width) && fits(size.height)) {
      return size;
    }
  }
  throw InputError("--size: '" + text +
                   "'; allowed: WIDTHxHEIGHT, each 64 to 8192, such as 1280x800");
}

}  // namespace

int view_verb(const SceneArguments& arguments, const ViewArguments& asked) {
  const SceneSource source{arguments.file, read_on_all(MPI_COMM_WORLD, arguments.file),
                           arguments.overrides};
  ViewOptions options;
  options.script = asked.script;
  options.frames = asked.frames;
  options.size = size_of_text(asked.size);
  options.letters = asked.letters;
  options.seconds = asked.seconds;
  view(MPI_COMM_WORLD, source, {}, options);
  return static_cast<int>(ExitCode::done);
}

}  // namespace stylet
