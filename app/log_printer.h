#pragma once
// Log lines on stderr, with simulated time, between redraws of the progress line.

#include <cstdio>

#include "app/console.h"
#include "cx/node/log.h"

namespace cxlab::app {

class LogPrinter : public cx::LogSink {
 public:
  LogPrinter(Progress& progress, bool quiet);
  void line(const cx::LogLine& line) override;

 private:
  Progress& progress_;
  bool quiet_, terminal_;
};

}  // namespace cxlab::app
