// Plays CLIPS programs as differential.py plays them with another build of CLIPS.
//
// clips_programs FILE...: each file has constructs, a line `%%`, and commands, a line each; `run N` fires N rules at
// most. A line of JSON for each: what was printed, and the errors.

#include <fstream>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cx/engine/engine.h"

namespace {

using cxlab::RuleEngine;
using cxlab::RuleError;

nlohmann::ordered_json play(const std::string& text, const std::string& file) {
  std::string printed;
  std::vector<std::string> errors;
  const auto report = [&](const std::vector<RuleError>& found) {
    for (const RuleError& error : found) {
      std::istringstream lines(error.detail);
      for (std::string line; std::getline(lines, line);)
        if (line.starts_with('[')) errors.insert(errors.end(), static_cast<std::size_t>(error.count), line);
    }
  };
  cxlab::EngineOptions options;
  options.on_output = [&](std::string_view name, std::string_view said) {
    if (name == "stdout") printed += said;
  };
  auto engine = RuleEngine::create(std::move(options));
  const std::size_t end = text.find("\n%%\n");
  report((*engine)
             ->load_text(std::string_view(text).substr(0, end), file, cxlab::LoadMode::kConstructs,
                         cxlab::OnLoadError::kKeepGoing)
             .errors);
  std::istringstream commands(text.substr(end + 4));
  for (std::string line; std::getline(commands, line);) {
    if (line.starts_with("run "))
      report((*engine)->run(std::stol(line.substr(4))).errors);
    else
      (void)(*engine)->eval(line);
    report((*engine)->take_errors());
  }
  return {{"printed", printed}, {"errors", errors}};
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    std::ifstream in(argv[i]);
    std::cout << play({std::istreambuf_iterator<char>(in), {}}, argv[i])
                     .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)
              << '\n';
  }
}
