// Plays the rows of rules_table.h.

#include "rules_table.h"

#include "game_script.h"

namespace cxlab::rcll {
namespace {

struct Case {
  const Row* row;
  std::string rules;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const auto rows : {instruction_rows, work_rows, piece_rows, breaking_rows, game_rows, delivery_rows,
                          exploration_rows, maintenance_rows, pause_rows})
    for (const Row& row : rows()) {
      std::istringstream in(row.under);
      for (std::string rules; in >> rules;) all.push_back({&row, rules});
    }
  return all;
}

void PrintTo(const Case& c, std::ostream* out) { *out << c.row->rule << ", rules: " << c.rules; }

class Rules : public testing::TestWithParam<Case> {};

TEST_P(Rules, Hold) {
  WorldConfig config;
  config.rules = GetParam().rules;
  GameScript().play(GetParam().row->script, config);
}

INSTANTIATE_TEST_SUITE_P(Table, Rules, testing::ValuesIn(cases()), [](const auto& row) {
  std::string name = std::string(row.param.row->rule) + " " + row.param.rules;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
});

}  // namespace
}  // namespace cxlab::rcll
