// The verb view where its packages were not there when the program was built.
#include "stylet/app/verbs.hpp"
#include "stylet/base/errors.hpp"

namespace stylet {

int view_verb(const SceneArguments& /*arguments*/, const ViewArguments& /*view*/) {
  throw InputError(
      "view: this program was built without the window; it needs libglfw3-dev, libepoxy-dev and "
      "libimgui-dev: bash jobs/view.sh installs them, builds and opens it");
}

}  // namespace stylet
