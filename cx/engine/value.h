#pragma once
// Values of CLIPS: owned (`Value`) and borrowed for the length of a call (`ValueRef`).

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cxlab {

enum class ValueType : std::uint8_t {
  kVoid,
  kInteger,
  kFloat,
  kSymbol,
  kString,
  kInstanceName,
  kHandle,
  kFact,
  kInstance,
  kMultifield
};

/// The value of an EXTERNAL-ADDRESS: a number counted from 1 in its environment, never used again. 0 = none.
enum class Handle : std::uint64_t { kNone = 0 };

/// A value that owns what it holds. Facts are held by their index.
class Value {
 public:
  Value() = default;
  static Value integer(std::int64_t v) { return Value(ValueType::kInteger, v, 0.0, {}); }
  static Value number(double v) { return Value(ValueType::kFloat, 0, v, {}); }
  static Value symbol(std::string text) { return Value(ValueType::kSymbol, 0, 0.0, std::move(text)); }
  static Value string(std::string text) { return Value(ValueType::kString, 0, 0.0, std::move(text)); }
  static Value instance_name(std::string text) { return Value(ValueType::kInstanceName, 0, 0.0, std::move(text)); }
  /// The symbol TRUE or FALSE.
  static Value boolean(bool v) { return symbol(v ? "TRUE" : "FALSE"); }
  static Value handle(Handle id) { return Value(ValueType::kHandle, static_cast<std::int64_t>(id), 0.0, {}); }
  static Value fact(std::int64_t index) { return Value(ValueType::kFact, index, 0.0, {}); }
  static Value multifield(std::vector<Value> items);

  ValueType type() const { return type_; }
  bool is(ValueType type) const { return type_ == type; }
  /// Symbol, string or instance name.
  bool is_text() const;
  bool is_number() const { return type_ == ValueType::kInteger || type_ == ValueType::kFloat; }
  /// Everything but the symbol FALSE, as CLIPS has it.
  bool is_true() const { return !(type_ == ValueType::kSymbol && text_ == "FALSE"); }

  std::int64_t as_integer() const { return type_ == ValueType::kFloat ? static_cast<std::int64_t>(number_) : integer_; }
  double as_number() const { return type_ == ValueType::kFloat ? number_ : static_cast<double>(integer_); }
  const std::string& text() const { return text_; }
  Handle as_handle() const { return static_cast<Handle>(integer_); }
  std::int64_t fact_index() const { return integer_; }
  const std::vector<Value>& items() const { return items_; }

  /// As CLIPS prints it in a fact: `"a string"`, `12.5`, `(1 2 3)`, `<Fact-4>`, `<Pointer-C-0x7>`.
  std::string print() const;

  bool operator==(const Value&) const = default;

 private:
  Value(ValueType type, std::int64_t integer, double number, std::string text)
      : type_(type), integer_(integer), number_(number), text_(std::move(text)) {}

  ValueType type_ = ValueType::kVoid;
  std::int64_t integer_ = 0;
  double number_ = 0.0;
  std::string text_;
  std::vector<Value> items_;
};

/// A value of CLIPS that is only borrowed: valid until control goes back to CLIPS.
class ValueRef {
 public:
  ValueRef() = default;
  /// `atom` is a CLIPS header of that type; `begin` and `size` are the part of a multifield.
  ValueRef(const void* atom, ValueType type, std::size_t begin, std::size_t size)
      : atom_(atom), begin_(begin), size_(size), type_(type) {}

  ValueType type() const { return type_; }
  bool is(ValueType type) const { return type_ == type; }
  bool is_text() const {
    return type_ == ValueType::kSymbol || type_ == ValueType::kString || type_ == ValueType::kInstanceName;
  }
  bool is_number() const { return type_ == ValueType::kInteger || type_ == ValueType::kFloat; }
  bool is_true() const { return !(type_ == ValueType::kSymbol && text() == "FALSE"); }

  /// A FLOAT is cut to its integer part, as CLIPS does.
  std::int64_t as_integer() const;
  double as_number() const;
  std::string_view text() const;
  Handle as_handle() const;
  std::int64_t fact_index() const;

  /// The number of fields of a multifield; 0 for any other value.
  std::size_t size() const { return size_; }
  ValueRef operator[](std::size_t i) const;

  Value copy() const;
  const void* atom() const { return atom_; }
  std::size_t begin() const { return begin_; }

 private:
  const void* atom_ = nullptr;
  std::size_t begin_ = 0;
  std::size_t size_ = 0;
  ValueType type_ = ValueType::kVoid;
};

/// A FLOAT as CLIPS prints it: 15 digits, with ".0" where it would look like an integer.
std::string print_float(double value);

}  // namespace cxlab
