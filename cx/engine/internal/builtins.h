#pragma once
// Code that the functions share that replace CLIPS's own.

#include <string>
#include <vector>

#include "impl.h"

namespace cxlab {

inline Builtin& builtin_of(clips::UDFContext* context) { return *static_cast<Builtin*>(context->context); }
inline RuleEngine::Impl& impl_of(clips::UDFContext* context) { return *builtin_of(context).impl; }
inline RuleEngine& engine_of(clips::UDFContext* context) { return impl_of(context).engine; }

/// Reports an error of the function, with the rule; the rule goes on.
void complain(clips::UDFContext* context, const std::string& why);
/// The same; the rule ends, and the function returns FALSE.
void refuse(clips::UDFContext* context, clips::UDFValue* result, const std::string& why);
/// All arguments; false after an error, which CLIPS has reported.
bool arguments(clips::UDFContext* context, std::vector<clips::UDFValue>& args);
/// Calls the function of CLIPS with these values as its arguments.
void call_original(clips::UDFContext* context, clips::UDFValue* result, const std::vector<clips::UDFValue>& args);

/// A call of a function that may come to call itself, as `eval` of a text with an `eval`; false, after an error, where
/// the stack is full of such calls.
class Nesting {
 public:
  Nesting(clips::UDFContext* context, clips::UDFValue* result);
  ~Nesting();
  Nesting(const Nesting&) = delete;
  Nesting& operator=(const Nesting&) = delete;
  explicit operator bool() const { return entered_; }

 private:
  RuleEngine::Impl& impl_;
  bool entered_;
};

/// Counts what reading that many bytes as rules costs.
inline void count_parsed(clips::UDFContext* context, std::size_t bytes) {
  clips::evaluation_data(context->environment)->Steps += kStepsOfAByte * bytes;
}

inline constexpr const char* kStatistics = "statistics";

// builtin_files.cpp
clips::UserDefinedFunction open_function, seek_function, load_function, batch_function, read_file_function,
    read_binary_function, region_function, write_file_function, write_binary_function, change_file_function;
// builtin_text.cpp
clips::UserDefinedFunction format_function, nested_function, text_function, scanning_function;
// builtin_later.cpp
void install_later_functions(clips::Environment* env);

}  // namespace cxlab
