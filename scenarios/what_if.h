#pragma once
// A change in the middle of a run: what of it is made and when. lab/what_if.h carries it out.

#include <string>
#include <vector>

namespace cxlab {

/// What changes at a time: at the first tick that is not before it, when the facts of that tick are there and before
/// any rule fires. Parameters are set first, then the file is loaded, globals are set, facts are asserted.
struct WhatIf {
  double at = 0;                      ///< s
  std::string file = {};              ///< of rules, as a person named it; empty: none
  std::string text = {};              ///< what is in it
  std::vector<std::string> set = {};  ///< NODE.NAME=VALUE, a parameter; ?*NAME*=VALUE, a global
  std::vector<std::string> facts = {};
  /// The environments that get the file, globals and facts. If it is empty, all get them; facts then need a single
  /// environment.
  std::vector<std::string> environments = {};
  std::string copy = {};  ///< where the run keeps the file, among its files (scenarios/kept_files.h)

  bool changes_nothing() const { return file.empty() && set.empty() && facts.empty(); }
  /// The file as errors and records of the run name it.
  std::string file_name() const;

  /// The text is not among them: it is in the copy.
  template <class Keys>
  void fields(Keys& keys) {
    keys.time("at", at);
    keys.unless_empty("then", file);
    keys.unless_empty("set", set);
    keys.unless_empty("assert", facts);
    keys.unless_empty("env", environments);
    keys.unless_empty("copy", copy);
  }
};

/// Says of each change of a run where the run keeps its file.
void name_copies(std::vector<WhatIf>& changes);

}  // namespace cxlab
