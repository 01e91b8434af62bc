#pragma once
// Makes a file from a film's frames: with ffmpeg, or for an animated image with cxlab's own code.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "cx/base/expected.h"
#include "sim/picture.h"

namespace cxlab::lab {

/// What kind of film a name stands for.
enum class FilmKind : std::uint8_t { kNone, kFfmpeg, kGif };
FilmKind film_kind(const std::string& file);
/// The endings of names of films, for people.
std::string film_endings();

struct FilmFormat {
  int width = 0, height = 0;           ///< px
  double rate = 25;                    ///< frames a second
  std::size_t most_bytes = 5'000'000;  ///< of an animated image
};

class FilmWriter {
 public:
  virtual ~FilmWriter() = default;
  /// The next frame.
  virtual Status put(const sim::Picture& picture) = 0;
  /// Completes the file; no frame can follow. What a person has to know about it, or nothing.
  virtual Expected<std::string> finish() = 0;
};

/// Writes `part`; errors name `film`. What it needs of the machine it opens now.
Expected<std::unique_ptr<FilmWriter>> film_writer(FilmKind kind, const FilmFormat& format,
                                                  const std::filesystem::path& part, const std::string& film);

}  // namespace cxlab::lab
