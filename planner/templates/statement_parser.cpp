#include <algorithm>
#include <set>

#include "planner/templates/parser.h"
#include "planner/templates/parser_base.h"
#include "planner/templates/scopes.h"

namespace cxlab::planner::templates {
namespace {

class StatementParser : public ExpressionParser {
 public:
  StatementParser(std::vector<Token> tokens, const std::string& name) : ExpressionParser(std::move(tokens), name) {
    template_ = std::make_unique<Template>();
    template_->name = name;
  }

  Expected<std::unique_ptr<Template>> run() {
    template_->body = body({});
    if (failed()) return error();
    if (Status status = resolve_scopes(*template_); !status) return status.error();
    return std::move(template_);
  }

 private:
  using Words = std::vector<std::string_view>;

  std::unique_ptr<Node> make_node(Node::Kind kind) const {
    auto node = std::make_unique<Node>();
    node->kind = kind;
    node->line = now().line;
    return node;
  }

  /// Statements up to one of `ends` (the tag is open then, its word not taken) or, without, to the end.
  Body body(const Words& ends) {
    Body nodes;
    ++depth_;
    if (depth_ > kDeepest) fail("statements are nested more than " + std::to_string(kDeepest) + " deep");
    const int line = now().line;
    while (!failed()) {
      if (now().kind == Token::Kind::kEnd) {
        if (!ends.empty())
          fail_at(line, "found the end of the template, expected {% " + std::string(ends.back()) + " %}");
        break;
      }
      if (now().kind == Token::Kind::kText) {
        nodes.push_back(make_node(Node::Kind::kText));
        nodes.back()->text = now().text;
        next();
      } else if (now().kind == Token::Kind::kOutputBegin) {
        next();
        nodes.push_back(make_node(Node::Kind::kOutput));
        nodes.back()->expression = tuple();
        if (!failed() && now().kind != Token::Kind::kOutputEnd) fail("found " + found() + ", expected '}}'");
        next();
      } else {
        next();
        if (ends_here(ends)) break;
        if (auto node = statement()) nodes.push_back(std::move(node));
      }
    }
    --depth_;
    return nodes;
  }

  bool ends_here(const Words& ends) const {
    for (const std::string_view word : ends)
      if (is_name(word)) return true;
    return false;
  }

  /// The end of a tag.
  void close() {
    if (failed()) return;
    if (now().kind != Token::Kind::kStatementEnd) fail("found " + found() + ", expected '%}'");
    next();
  }

  /// Body of a statement that ends with one word; takes the end tag.
  Body body_until(std::string_view end) {
    Body nodes = body({end});
    next();
    close();
    return nodes;
  }

  std::unique_ptr<Node> statement() {
    const int line = now().line;
    const std::string word = expect_name("a statement");
    if (failed()) return nullptr;
    if (word == "for") return for_statement(line);
    if (word == "if") return if_statement(line);
    if (word == "set") return set_statement(line);
    if (word == "block") return block_statement(line);
    if (word == "extends") return simple(Node::Kind::kExtends, line);
    if (word == "do") return simple(Node::Kind::kDo, line);
    if (word == "include") return include_statement(line);
    if (word == "import") return import_statement(line);
    if (word == "from") return from_statement(line);
    if (word == "macro") return macro_statement(line);
    if (word == "call") return call_statement(line);
    if (word == "filter") return filter_statement(line);
    if (word == "with") return with_statement(line);
    if (word == "autoescape" || word == "trans" || word == "debug" || word == "break" || word == "continue") {
      fail_unsupported(line, "found the statement '" + word + "': not supported");
    } else {
      refuse(line, word);
    }
    return nullptr;
  }

  /// A tag that begins no statement: one that ends or continues another, or a misspelt one.
  void refuse(int line, const std::string& word) {
    static const std::vector<std::string> kBegin = {"for",  "if",    "set",  "block",  "extends", "include", "import",
                                                    "from", "macro", "call", "filter", "with",    "do",      "raw"};
    static const std::vector<std::string> kGoOn = {"else",     "elif",    "endfor",    "endif",   "endset", "endblock",
                                                   "endmacro", "endcall", "endfilter", "endwith", "endraw"};
    if (std::find(kGoOn.begin(), kGoOn.end(), word) != kGoOn.end()) {
      fail_at(line, "found {% " + word + " %}, which ends or continues nothing");
      return;
    }
    std::vector<std::string> all = kBegin;
    all.insert(all.end(), kGoOn.begin(), kGoOn.end());
    std::string list;
    for (const std::string& known : all) list += (list.empty() ? "" : ", ") + known;
    fail_at(line, "found '" + word + "', expected a statement: " + list + did_you_mean(word, all, "; "));
  }

  std::unique_ptr<Node> begin(Node::Kind kind, int line) const {
    auto node = make_node(kind);
    node->line = line;
    return node;
  }

  std::unique_ptr<Node> simple(Node::Kind kind, int line) {
    auto node = begin(kind, line);
    node->expression = expression();
    close();
    return node;
  }

  std::unique_ptr<Node> for_statement(int line) {
    auto node = begin(Node::Kind::kFor, line);
    node->target = target(false);
    if (!failed() && !take_name("in")) fail("found " + found() + ", expected 'in'");
    node->expression = tuple(/*with_condition=*/false);
    if (take_name("if")) node->filter = expression();
    node->recursive = take_name("recursive");
    close();
    node->body = body({"else", "endfor"});
    if (take_name("else")) {
      close();
      node->otherwise = body({"endfor"});
    }
    next();
    close();
    return node;
  }

  std::unique_ptr<Node> if_statement(int line) {
    auto first = begin(Node::Kind::kIf, line);
    Node* last = first.get();
    last->expression = tuple(/*with_condition=*/false);
    close();
    while (!failed()) {
      last->body = body({"elif", "else", "endif"});
      if (failed()) break;
      const int at = now().line;
      if (take_name("elif")) {
        auto more = begin(Node::Kind::kIf, at);
        more->expression = tuple(/*with_condition=*/false);
        close();
        last->otherwise.push_back(std::move(more));
        last = last->otherwise.back().get();
        if (++elifs_ > kMostElifs) fail("found more than " + std::to_string(kMostElifs) + " elif in one template");
        continue;
      }
      if (take_name("else")) {
        close();
        last->otherwise = body({"endif"});
      }
      next();
      close();
      break;
    }
    return first;
  }

  std::unique_ptr<Node> set_statement(int line) {
    auto node = begin(Node::Kind::kSet, line);
    node->target = target(true);
    if (failed()) return nullptr;
    if (take_operator("=")) {
      node->expression = tuple();
      close();
      return node;
    }
    node->kind = Node::Kind::kSetBlock;
    if (is_operator("|")) node->expression = filters(nullptr);
    close();
    node->body = body_until("endset");
    return node;
  }

  std::unique_ptr<Node> block_statement(int line) {
    auto node = begin(Node::Kind::kBlock, line);
    node->text = expect_name("the name of the block");
    node->scoped = take_name("scoped");
    node->required = take_name("required");
    close();
    node->body = body({"endblock"});
    for (const auto& inside : node->body)
      if (node->required &&
          (inside->kind != Node::Kind::kText || inside->text.find_first_not_of(kWhitespace) != std::string::npos))
        fail_at(inside->line, "found contents of the block '" + node->text +
                                  "', which is required: expected only blanks and comments");
    next();
    if (now().kind == Token::Kind::kName && !take_name(node->text))
      fail("found " + found() + ", expected '" + node->text + "', the name of the block that ends here");
    close();
    if (!failed() && !template_->blocks.emplace(node->text, node.get()).second)
      fail_at(line, "found block '" + node->text + "' a second time; declared at " + template_->name + ":" +
                        std::to_string(template_->blocks[node->text]->line));
    return node;
  }

  void context_of(Node& node) {
    const bool with = is_name("with"), without = is_name("without");
    if ((!with && !without) || ahead().text != "context") return;
    next();
    next();
    node.with_context = with;
  }

  std::unique_ptr<Node> include_statement(int line) {
    auto node = begin(Node::Kind::kInclude, line);
    node->expression = expression();
    if (is_name("ignore") && ahead().text == "missing") {
      next();
      next();
      node->ignore_missing = true;
    }
    context_of(*node);
    close();
    return node;
  }

  std::unique_ptr<Node> import_statement(int line) {
    auto node = begin(Node::Kind::kImport, line);
    node->with_context = false;
    node->expression = expression();
    if (!failed() && !take_name("as")) fail("found " + found() + ", expected 'as'");
    node->text = expect_name("a name for what is imported");
    context_of(*node);
    close();
    return node;
  }

  std::unique_ptr<Node> from_statement(int line) {
    auto node = begin(Node::Kind::kFromImport, line);
    node->with_context = false;
    node->expression = expression();
    if (!failed() && !take_name("import")) fail("found " + found() + ", expected 'import'");
    while (!failed()) {
      if ((is_name("with") || is_name("without")) && ahead().text == "context") break;
      std::string name = expect_name("a name to import");
      if (name.starts_with('_'))
        fail("found '" + name + "', but names that begin with an underscore cannot be imported");
      std::string alias = take_name("as") ? expect_name("a name") : name;
      node->names.emplace_back(std::move(name), std::move(alias));
      if (!take_operator(",") || now().kind == Token::Kind::kStatementEnd) break;
    }
    context_of(*node);
    close();
    return node;
  }

  void parameters(Node& node) {
    if (!expect_operator("(")) return;
    while (!failed() && !is_operator(")")) {
      std::string name = expect_name("a parameter");
      if (std::any_of(node.parameters.begin(), node.parameters.end(),
                      [&](const auto& each) { return each.first == name; }))
        fail("found the parameter '" + name + "' a second time");
      ExpressionPtr value = take_operator("=") ? expression() : nullptr;
      if (!failed() && !value && !node.parameters.empty() && node.parameters.back().second)
        fail("found a parameter without default behind one with a default");
      node.parameters.emplace_back(std::move(name), std::move(value));
      if (!is_operator(")") && !expect_operator(",")) break;
    }
    next();
  }

  std::unique_ptr<Node> macro_statement(int line) {
    auto node = begin(Node::Kind::kMacro, line);
    node->text = expect_name("the name of the macro");
    parameters(*node);
    close();
    node->body = body_until("endmacro");
    return node;
  }

  std::unique_ptr<Node> call_statement(int line) {
    auto node = begin(Node::Kind::kCallBlock, line);
    if (is_operator("(")) parameters(*node);
    node->expression = expression();
    if (!failed() && node->expression->kind != Expression::Kind::kCall) fail_at(line, "expected {% call MACRO(...) %}");
    close();
    node->body = body_until("endcall");
    return node;
  }

  std::unique_ptr<Node> filter_statement(int line) {
    auto node = begin(Node::Kind::kFilterBlock, line);
    node->expression = filter(nullptr);
    if (!failed()) node->expression = filters(std::move(node->expression));
    close();
    node->body = body_until("endfilter");
    return node;
  }

  std::unique_ptr<Node> with_statement(int line) {
    auto node = begin(Node::Kind::kWith, line);
    while (!failed() && now().kind != Token::Kind::kStatementEnd) {
      std::string name = expect_name("a name");
      if (!expect_operator("=")) break;
      node->parameters.emplace_back(std::move(name), expression());
      if (!take_operator(",")) break;
    }
    close();
    node->body = body_until("endwith");
    return node;
  }

  /// elif nests in the tree.
  static constexpr int kMostElifs = 1000;
  int elifs_ = 0;
  std::unique_ptr<Template> template_;
};

}  // namespace

Expected<std::unique_ptr<Template>> parse_template(std::string_view source, const std::string& name) {
  auto tokens = tokenize(source, name);
  if (!tokens) return tokens.error();
  return StatementParser(std::move(*tokens), name).run();
}

}  // namespace cxlab::planner::templates
