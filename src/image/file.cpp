// The only file that knows libpng and libjpeg.
#include "stylet/image/file.hpp"

#include "stylet/base/errors.hpp"

#include <memory>
#include <png.h>
#include <string_view>
#include <turbojpeg.h>

namespace stylet {

namespace {

constexpr int longest_side = 16384;  // pixels

void require_size(const std::string& name, long width, long height) {
  if (width >= 1 && height >= 1 && width <= longest_side && height <= longest_side) return;
  throw InputError(name + ": a picture of " + std::to_string(width) + " x " +
                   std::to_string(height) + " pixels; allowed: 1 to " +
                   std::to_string(longest_side) + " a side");
}

Picture sized(long width, long height, int channels) {
  Picture picture;
  picture.width = static_cast<int>(width);
  picture.height = static_cast<int>(height);
  picture.channels = channels;
  picture.bytes.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                       static_cast<std::size_t>(channels));
  return picture;
}

Picture read_png(const std::string& name, const std::string& bytes) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  const auto fail = [&] {
    const std::string message = image.message;
    png_image_free(&image);
    throw InputError(name + ": not a PNG picture that can be read: " + message);
  };
  if (png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) == 0) fail();
  try {
    require_size(name, image.width, image.height);
  } catch (...) {
    png_image_free(&image);
    throw;
  }
  const bool is_grey = (image.format & PNG_FORMAT_FLAG_COLOR) == 0;
  image.format = is_grey ? PNG_FORMAT_GRAY : PNG_FORMAT_RGB;
  Picture picture = sized(image.width, image.height, is_grey ? 1 : 3);
  const png_color black{0, 0, 0};  // below what is transparent
  if (png_image_finish_read(&image, &black, picture.bytes.data(), 0, nullptr) == 0) fail();
  return picture;
}

Picture read_jpeg(const std::string& name, const std::string& bytes) {
  const std::unique_ptr<void, int (*)(void*)> jpeg(tjInitDecompress(), tjDestroy);
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  const auto fail = [&] {
    throw InputError(name + ": not a JPEG picture that can be read: " + tjGetErrorStr2(jpeg.get()));
  };
  int width = 0;
  int height = 0;
  int sampling = 0;
  int colours = 0;
  if (tjDecompressHeader3(jpeg.get(), data, bytes.size(), &width, &height, &sampling, &colours) !=
      0) {
    fail();
  }
  require_size(name, width, height);
  const bool is_grey = colours == TJCS_GRAY;
  Picture picture = sized(width, height, is_grey ? 1 : 3);
  // A warning, of data that end too early, is a failure too.
  if (tjDecompress2(jpeg.get(), data, bytes.size(), picture.bytes.data(), width, 0, height,
                    is_grey ? TJPF_GRAY : TJPF_RGB, 0) != 0) {
    fail();
  }
  return picture;
}

}  // namespace

Picture read_picture(const std::string& name, const std::string& bytes) {
  const std::string_view start = bytes;
  if (start.starts_with("\x89PNG")) return read_png(name, bytes);
  if (start.starts_with("\xff\xd8\xff")) return read_jpeg(name, bytes);
  throw InputError(name + ": neither a PNG nor a JPEG picture");
}

std::string png_of(const Picture& picture) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = picture.channels == 1 ? PNG_FORMAT_GRAY : PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.bytes.data(), 0, nullptr) ==
      0) {
    throw IoError(std::string("the picture cannot be written as PNG: ") + image.message);
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace stylet
