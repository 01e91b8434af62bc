#include "sim/picture.h"

#include <fcntl.h>
#include <png.h>
#include <unistd.h>

#include <cstdio>
#include <memory>

namespace cxlab::sim {

Status write_png(const Picture& picture, const std::filesystem::path& file) {
  const auto failed = [&] { return resource_error("cannot write the picture", file.string()); };
  const int handle = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK, 0666);
  if (handle < 0) return failed();  // also a pipe from which nobody reads
  fcntl(handle, F_SETFL, O_WRONLY);
  std::unique_ptr<FILE, int (*)(FILE*)> out(fdopen(handle, "wb"), std::fclose);
  if (!out) return failed();
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGB;
  image.flags = PNG_IMAGE_FLAG_FAST;
  const bool written =
      png_image_write_to_stdio(&image, out.get(), 0, picture.rgb.data(), 3 * picture.width, nullptr) != 0;
  if (!written || std::fclose(out.release()) != 0) return failed();
  return {};
}

}  // namespace cxlab::sim
