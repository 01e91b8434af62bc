#pragma once
// The world of a story (docs/reference/stories.md): stand-ins for skills and services, and what happens at its times.

#include "scenarios/catalogue.h"

namespace cxlab::story {

extern const WorldKind kWorld;

/// `world: {kind: story, file: FILE, story: NAME}`. What it expects is not judged here.
struct Config {
  std::string file;   ///< of stories
  std::string story;  ///< the name of one of them
  int line = 0;       ///< on which it begins, where several have the name; 0: the first one

  template <class Keys>
  void fields(Keys& keys) {
    keys.required("file", file);
    keys.required("story", story);
    keys("line", line);
  }
};

}  // namespace cxlab::story
