#include "cx/check/graph.h"

#include <algorithm>
#include <map>
#include <set>

namespace cxlab::check {

namespace {

/// What one construct does with the facts of a template.
struct Deeds {
  bool asserts = false, modifies = false, retracts = false, reads = false, reads_not = false;
  bool produces() const { return asserts || modifies; }
  bool consumes() const { return retracts || reads || reads_not; }
};
using Doers = std::map<std::string, Deeds>;  // by name, with the kind where it is no rule

std::string name_of(const Construct& construct) {
  if (construct.is_rule()) return construct.name;
  if (construct.kind == "deffunction" || construct.kind == "deffacts") return construct.kind + ' ' + construct.name;
  return "a call in " + construct.place.source->file.substr(construct.place.source->file.rfind('/') + 1);
}

/// By template; those that concern a judged file.
std::map<std::string, Doers> doers_of(const RuleBase& base) {
  std::set<std::string> wanted;
  for (const Touch& touch : base.touches())
    if (touch.by->judged()) wanted.insert(touch.template_name);
  std::map<std::string, Doers> out;
  for (const Touch& touch : base.touches()) {
    if (!wanted.contains(touch.template_name) || touch.template_name.empty() || !touch.by->place.source->loaded)
      continue;
    Deeds& deeds = out[touch.template_name][name_of(*touch.by)];
    deeds.asserts = deeds.asserts || touch.how == How::kAssert;
    deeds.modifies = deeds.modifies || touch.how == How::kModify;
    deeds.retracts = deeds.retracts || touch.how == How::kRetract;
    deeds.reads = deeds.reads || touch.how == How::kRead;
    deeds.reads_not = deeds.reads_not || touch.how == How::kReadNot;
  }
  for (auto& [name, doers] : out)
    if (base.outside().templates.contains(name) || base.outside().facts.contains(name))
      doers["(plugins)"] = {.asserts = true, .reads = true};
  return out;
}

std::string dot_text(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += (c == '"' || c == '\\') ? std::string("\\") + c : std::string(1, c);
  return out + '"';
}

/// For XML: a byte that is no UTF-8, and a control character, becomes U+FFFD.
std::string escaped(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const std::size_t length = lead < 0x80   ? 1
                               : lead < 0xc2 ? 0
                               : lead < 0xe0 ? 2
                               : lead < 0xf0 ? 3
                               : lead < 0xf5 ? 4
                                             : 0;
    bool whole = length > 0 && lead >= 0x20 && i + length <= text.size();
    for (std::size_t k = 1; whole && k < length; ++k) whole = (static_cast<unsigned char>(text[i + k]) & 0xc0U) == 0x80;
    const std::string one = whole ? text.substr(i, length) : "\xef\xbf\xbd";
    out += one == "&" ? "&amp;" : one == "<" ? "&lt;" : one == ">" ? "&gt;" : one == "\"" ? "&quot;" : one;
    i += whole ? length : 1;
  }
  return out;
}

std::string list(std::initializer_list<std::pair<bool, const char*>> deeds) {
  std::string out;
  for (const auto& [does, word] : deeds)
    if (does) out += (out.empty() ? "" : ", ") + std::string(word);
  return out;
}

std::string makes(const Deeds& deeds) { return list({{deeds.asserts, "asserts"}, {deeds.modifies, "modifies"}}); }
std::string takes(const Deeds& deeds) {
  return list({{deeds.reads, "reads"}, {deeds.reads_not, "not"}, {deeds.retracts, "retracts"}});
}

// --- The picture: one block below the other

constexpr int kRow = 22, kLeft = 20, kBox = 300, kMiddle = 240, kWay = 150, kGap = 18, kTop = 60;
constexpr int kX2 = kLeft + kBox + kWay, kX3 = kX2 + kMiddle + kWay, kWidth = kX3 + kBox + kLeft;

std::string box(int x, int y, int width, int height, const std::string& text, const char* look) {
  const int baseline = y + height / 2 + 4;
  constexpr std::size_t kFits = 40;
  const std::string shown = text.size() > kFits ? text.substr(0, kFits - 3) + "..." : text;
  return "<g class=\"" + std::string(look) + "\"><title>" + escaped(text) + "</title><rect x=\"" + std::to_string(x) +
         "\" y=\"" + std::to_string(y) + "\" width=\"" + std::to_string(width) + "\" height=\"" +
         std::to_string(height) + "\" rx=\"4\"/><text x=\"" + std::to_string(x + 8) + "\" y=\"" +
         std::to_string(baseline) + "\">" + escaped(shown) + "</text></g>\n";
}

std::string arrow(int x1, int y1, int x2, int y2, const std::string& what, int label_y, const char* look) {
  const int middle = (x1 + x2) / 2;
  return "<path class=\"" + std::string(look) + "\" d=\"M" + std::to_string(x1) + ' ' + std::to_string(y1) + " C" +
         std::to_string(middle) + ' ' + std::to_string(y1) + ' ' + std::to_string(middle) + ' ' + std::to_string(y2) +
         ' ' + std::to_string(x2) + ' ' + std::to_string(y2) +
         "\" marker-end=\"url(#head)\"/><text class=\"what\" x=\"" + std::to_string(x1 < kX2 ? x1 + 4 : x2 - 8) +
         "\" y=\"" + std::to_string(label_y - 3) + "\"" + (x1 < kX2 ? "" : " text-anchor=\"end\"") + '>' + what +
         "</text>\n";
}

}  // namespace

std::string graph_dot(const RuleBase& base, const std::string& title) {
  std::string nodes, arrows;
  std::set<std::string> rules;
  for (const auto& [name, doers] : doers_of(base)) {
    nodes += "  " + dot_text("(" + name + ")") + " [shape=ellipse, style=filled, fillcolor=\"#fff2cc\"];\n";
    for (const auto& [doer, deeds] : doers) {
      rules.insert(doer);
      if (deeds.produces())
        arrows += "  " + dot_text(doer) + " -> " + dot_text("(" + name + ")") +
                  " [color=\"#2e7d32\", tooltip=" + dot_text(makes(deeds)) + "];\n";
      if (deeds.consumes())
        arrows += "  " + dot_text("(" + name + ")") + " -> " + dot_text(doer) + " [tooltip=" + dot_text(takes(deeds)) +
                  (deeds.reads ? "" : ", style=dashed") + "];\n";
    }
  }
  for (const std::string& rule : rules) nodes += "  " + dot_text(rule) + " [shape=box];\n";
  return "digraph rules {\n  rankdir=LR;\n  label=" + dot_text(title) + ";\n" + nodes + arrows + "}\n";
}

std::string graph_svg(const RuleBase& base, const std::string& title) {
  std::string body;
  int y = kTop;
  for (const auto& [name, doers] : doers_of(base)) {
    std::vector<std::pair<std::string, Deeds>> makers, takers;
    for (const auto& [doer, deeds] : doers) {
      if (deeds.produces()) makers.emplace_back(doer, deeds);
      if (deeds.consumes()) takers.emplace_back(doer, deeds);
    }
    const int rows = static_cast<int>(std::max<std::size_t>({makers.size(), takers.size(), 1}));
    const int height = rows * kRow, middle = y + height / 2;
    const auto draw = [&](const std::vector<std::pair<std::string, Deeds>>& doing, bool left) {
      int top = y + (rows - static_cast<int>(doing.size())) * kRow / 2;
      for (const auto& [doer, deeds] : doing) {
        const int center = top + kRow / 2;
        body += box(left ? kLeft : kX3, top + 2, kBox, kRow - 4, doer, "rule");
        body +=
            left ? arrow(kLeft + kBox, center, kX2, middle, makes(deeds), center, "makes")
                 : arrow(kX2 + kMiddle, middle, kX3, center, takes(deeds), center, deeds.reads ? "reads" : "without");
        top += kRow;
      }
    };
    draw(makers, true);
    draw(takers, false);
    if (makers.empty()) body += box(kLeft, middle - 9, kBox, kRow - 4, "nothing asserts it", "none");
    if (takers.empty()) body += box(kX3, middle - 9, kBox, kRow - 4, "nothing reads it", "none");
    body += box(kX2, middle - 13, kMiddle, 26, name, "facts");
    y += height + kGap;
  }
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + std::to_string(kWidth) + "\" height=\"" +
         std::to_string(y) + "\" viewBox=\"0 0 " + std::to_string(kWidth) + ' ' + std::to_string(y) +
         "\" font-family=\"sans-serif\" font-size=\"12\">\n<style>rect{fill:#f5f7fa;stroke:#8a97a8} .facts "
         "rect{fill:#fff2cc;stroke:#b8860b} .facts text{font-weight:bold} .none rect{fill:#fde7e7;stroke:#c62828} "
         "path{fill:none;stroke:#607d8b} .makes{stroke:#2e7d32} .without{stroke-dasharray:4 3} "
         ".what{font-size:10px;fill:#607080;stroke:white;stroke-width:3px;paint-order:stroke} "
         ".title{font-size:15px;font-weight:bold}</style>\n<defs><marker "
         "id=\"head\" "
         "markerWidth=\"8\" markerHeight=\"8\" refX=\"7\" refY=\"4\" orient=\"auto\"><path d=\"M0 0 L8 4 L0 8 z\" "
         "style=\"fill:#607d8b;stroke:none\"/></marker></defs>\n<rect x=\"0\" y=\"0\" width=\"100%\" height=\"100%\" "
         "style=\"fill:white;stroke:none\"/>\n<text class=\"title\" x=\"20\" y=\"24\">" +
         escaped(title) + "</text>\n<text x=\"20\" y=\"46\">produced by</text><text x=\"" + std::to_string(kX2) +
         "\" y=\"46\">facts</text><text x=\"" + std::to_string(kX3) + "\" y=\"46\">read by</text>\n" + body +
         "</svg>\n";
}

}  // namespace cxlab::check
