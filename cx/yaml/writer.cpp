#include "cx/yaml/writer.h"

#include <yaml-cpp/yaml.h>

#include "cx/base/number_text.h"

namespace cxlab::yaml {

namespace {

void emit(YAML::Emitter& out, const YAML::Node& node) {
  const bool flow = node.Style() == YAML::EmitterStyle::Flow;
  if (node.IsMap()) {
    out << (flow ? YAML::Flow : YAML::Block) << YAML::BeginMap;
    for (const auto& entry : node) {
      out << YAML::Key;
      emit(out, entry.first);
      out << YAML::Value;
      emit(out, entry.second);
    }
    out << YAML::EndMap;
  } else if (node.IsSequence()) {
    out << (flow ? YAML::Flow : YAML::Block) << YAML::BeginSeq;
    for (const auto& item : node) emit(out, item);
    out << YAML::EndSeq;
  } else if (node.IsScalar() && node.Tag() == "!") {
    out << YAML::DoubleQuoted << node.Scalar();
  } else {
    out << node;
  }
}

}  // namespace

std::string to_text(const YAML::Node& node) {
  YAML::Emitter out;
  emit(out, node);
  return out.c_str();
}

Writer::Writer() : node_(std::make_shared<YAML::Node>(YAML::NodeType::Map)) {}

void Writer::operator()(std::string_view key, const std::string& value) { (*node_)[std::string(key)] = value; }
void Writer::operator()(std::string_view key, double value) { (*this)(key, shortest_text(value)); }
void Writer::operator()(std::string_view key, std::int64_t value) { (*this)(key, std::to_string(value)); }
void Writer::operator()(std::string_view key, std::uint64_t value) { (*this)(key, std::to_string(value)); }
void Writer::operator()(std::string_view key, bool value) { (*this)(key, std::string(value ? "true" : "false")); }

void Writer::operator()(std::string_view key, const std::vector<std::string>& values) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (const std::string& value : values) list.push_back(value);
  (*node_)[std::string(key)] = list;
}

void Writer::operator()(std::string_view key, const std::vector<std::pair<std::string, std::string>>& map) {
  YAML::Node entries(YAML::NodeType::Map);
  for (const auto& [name, text] : map) entries[name] = text;
  (*node_)[std::string(key)] = entries;
}

void Writer::put_yaml(std::string_view key, const std::string& yaml) {
  try {
    (*node_)[std::string(key)] = YAML::Load(yaml);
  } catch (const YAML::Exception&) {
    (*this)(key, yaml);
  }
}

void Writer::put(std::string_view key, const Writer& map) { (*node_)[std::string(key)] = *map.node_; }

void Writer::add(const Writer& other) {
  for (const auto& entry : *other.node_) (*node_)[entry.first.Scalar()] = entry.second;
}

void Writer::append(std::string_view key, const Writer& item) { (*node_)[std::string(key)].push_back(*item.node_); }

void Writer::remove_equal(const Writer& other) {
  YAML::Node rest(YAML::NodeType::Map);
  for (const auto& entry : *node_) {
    const YAML::Node before = (*other.node_)[entry.first.Scalar()];
    if (!before.IsDefined() || to_text(before) != to_text(entry.second)) rest[entry.first.Scalar()] = entry.second;
  }
  *node_ = rest;
}

bool Writer::empty() const { return node_->size() == 0; }

std::string Writer::text() const { return to_text(*node_) + '\n'; }

}  // namespace cxlab::yaml
