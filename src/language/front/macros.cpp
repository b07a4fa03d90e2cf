// Macro expansion. An expansion is a context that is read before the file goes on; its macro is not expanded again
// until the context has been read to its end, and a name met in that time stays as it is for ever.
#include <algorithm>

#include "language/front/preprocessor.h"

namespace kinora::language::front {

namespace {

constexpr uint64_t kMostWork = 4'000'000;
constexpr uint32_t kMostNested = 200;

}  // namespace

void Preprocessor::push(std::vector<Token> tokens, Macro* macro) {
  work_ += tokens.size() + 1;
  if (work_ > kMostWork)
    messages_.fatal(tokens.empty() ? Pos{} : tokens[0].pos, "macros expand to more than the compiler takes");
  if (macro) ++macro->disabled;
  contexts_.push_back({std::move(tokens), 0, macro});
}

Token Preprocessor::raw() {
  while (contexts_.size() > floor_) {
    Context& c = contexts_.back();
    if (c.at < c.tokens.size()) {
      Token t = c.tokens[c.at++];
      if (t.kind == Token::Kind::Identifier && !t.isPainted)
        if (const Macro* m = macroOf(t.name)) t.isPainted = m->disabled > 0;
      return t;
    }
    if (c.macro) --c.macro->disabled;
    contexts_.pop_back();
  }
  return floor_ > 0 ? Token() : fileToken();
}

Token Preprocessor::expanded() {
  for (;;) {
    Token t = raw();
    if (t.kind != Token::Kind::Identifier || t.isPainted) return t;
    Macro* macro = macroOf(t.name);
    if (!macro || !expand(t, *macro)) return t;
  }
}

// False: `name` stands for itself. What follows is read from contexts_.
bool Preprocessor::expand(Token& name, Macro& macro) {
  if (macro.own != Macro::Own::No) {
    Token t = name;
    if (macro.own == Macro::Own::Line) {
      t.kind = Token::Kind::Number;
      t.text = pool_.copy(std::to_string(name.pos.line));
    } else {
      t.kind = Token::Kind::String;
      std::string s = "\"";
      for (const char c : messages_.nameOf(name.pos.file))
        s += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
      t.text = pool_.copy(s + "\"");
    }
    t.name = 0;
    name = t;
    return false;
  }
  std::vector<std::vector<Token>> args;
  if (macro.isFunction && !arguments(name, macro, args)) return false;
  std::vector<Token> tokens = substituted(name, macro, std::move(args));
  if (!tokens.empty()) {
    tokens[0].hasSpaceBefore = name.hasSpaceBefore;
    tokens[0].isFirstOfLine = name.isFirstOfLine;
  }
  push(std::move(tokens), &macro);
  return true;
}

// False when no call follows; what was read is put back.
bool Preprocessor::arguments(const Token& name, const Macro& macro, std::vector<std::vector<Token>>& out) {
  Token t = raw();
  if (t.punct != Punct::LParen) {
    if (t.kind != Token::Kind::End) push({t}, nullptr);
    return false;
  }
  std::vector<Token> read = {t};
  out.assign(1, {});
  for (int depth = 0;;) {
    t = raw();
    if (t.kind == Token::Kind::End) {
      if (floor_ == 0)
        messages_.fatal(name.pos, "the call of macro '" + std::string(name.text) + "' has no closing parenthesis");
      push(std::move(read), nullptr);
      return false;
    }
    if (++work_ > kMostWork) messages_.fatal(name.pos, "macros expand to more than the compiler takes");
    if (floor_ > 0) read.push_back(t);
    if (t.punct == Punct::LParen) ++depth;
    if (t.punct == Punct::RParen && depth-- == 0) break;
    if (t.punct == Punct::Comma && depth == 0 && !(macro.isVariadic && out.size() >= macro.parameters.size()))
      out.emplace_back();
    else
      out.back().push_back(t);
  }
  if (macro.parameters.empty() && out.size() == 1 && out[0].empty()) out.clear();
  if (macro.isVariadic && out.size() + 1 == macro.parameters.size()) out.emplace_back();
  if (out.size() == macro.parameters.size()) return true;
  messages_.error(name.pos, "macro '" + std::string(name.text) + "' takes " +
                                std::to_string(macro.parameters.size()) + " arguments, not " +
                                std::to_string(out.size()));
  out.resize(macro.parameters.size());
  return true;
}

std::vector<Token> Preprocessor::substituted(const Token& name, const Macro& macro,
                                             std::vector<std::vector<Token>> arguments) {
  const auto parameter = [&](const Token& t) -> int {
    if (t.kind != Token::Kind::Identifier || !macro.isFunction) return -1;
    const auto at = std::find(macro.parameters.begin(), macro.parameters.end(), t.name);
    return at == macro.parameters.end() ? -1 : int(at - macro.parameters.begin());
  };
  std::vector<Token> out;
  std::vector<std::optional<std::vector<Token>>> expansions(arguments.size());
  const auto append = [&](const std::vector<Token>& tokens, bool hasSpace) {
    work_ += tokens.size();
    if (work_ > kMostWork) messages_.fatal(name.pos, "macros expand to more than the compiler takes");
    const size_t first = out.size();
    out.insert(out.end(), tokens.begin(), tokens.end());
    if (out.size() > first) out[first].hasSpaceBefore = hasSpace;
  };
  for (size_t i = 0; i < macro.body.size(); ++i) {
    Token t = macro.body[i];
    t.pos = name.pos;
    t.isFirstOfLine = false;
    if (t.punct == Punct::Hash && macro.isFunction && i + 1 < macro.body.size()) {
      if (const int p = parameter(macro.body[i + 1]); p >= 0) {
        out.push_back(stringOf(arguments[size_t(p)], t));
        ++i;
        continue;
      }
    }
    if (t.punct == Punct::HashHash && i + 1 < macro.body.size()) {  // the left side stands at the end of out
      const int p = parameter(macro.body[i + 1]);
      std::vector<Token> right;
      if (p >= 0) {
        right = arguments[size_t(p)];
        const bool isRest = macro.isVariadic && size_t(p) + 1 == macro.parameters.size();
        if (isRest && !out.empty() && out.back().punct == Punct::Comma) {  // , ## __VA_ARGS__
          if (right.empty())
            out.pop_back();
          else
            append(right, true);
          ++i;
          continue;
        }
      } else {
        right = {macro.body[i + 1]};
        right[0].pos = name.pos;
      }
      const bool hasLeft =
          i > 0 && !(parameter(macro.body[i - 1]) >= 0 && arguments[size_t(parameter(macro.body[i - 1]))].empty());
      if (hasLeft && !out.empty() && !right.empty()) {
        out.back() = pasted(out.back(), right[0]);
        right.erase(right.begin());
      }
      append(right, false);
      ++i;
      continue;
    }
    const int p = parameter(t);
    if (p < 0) {
      out.push_back(t);
      continue;
    }
    const bool isPasted = i + 1 < macro.body.size() && macro.body[i + 1].punct == Punct::HashHash;
    if (isPasted) {
      append(arguments[size_t(p)], t.hasSpaceBefore);
      continue;
    }
    auto& e = expansions[size_t(p)];
    if (!e) e = expandedAlone(arguments[size_t(p)]);
    append(*e, t.hasSpaceBefore);
  }
  return out;
}

std::vector<Token> Preprocessor::expandedAlone(const std::vector<Token>& tokens) {
  if (std::none_of(tokens.begin(), tokens.end(), [&](const Token& t) {
        return t.kind == Token::Kind::Identifier && !t.isPainted && macroOf(t.name);
      }))
    return tokens;
  if (++nested_ > kMostNested) messages_.fatal(tokens[0].pos, "macro calls are nested too deeply");
  const size_t floor = floor_;
  // the file must not be read: a context of nobody lies below
  contexts_.push_back({});
  floor_ = contexts_.size();
  push(tokens, nullptr);
  std::vector<Token> out;
  for (Token t = expanded(); t.kind != Token::Kind::End; t = expanded()) out.push_back(t);
  contexts_.pop_back();
  floor_ = floor;
  --nested_;
  return out;
}

Token Preprocessor::pasted(const Token& a, const Token& b) {
  const std::string_view text = pool_.copy(std::string(a.text) + std::string(b.text));
  Lexer lexer(text, a.pos.file, names_, messages_);
  Token t = lexer.next();
  if (t.kind == Token::Kind::Bad || t.text.size() != text.size()) {
    messages_.error(a.pos, "pasting '" + std::string(a.text) + "' and '" + std::string(b.text) + "' gives no token");
    return a;
  }
  t.pos = a.pos;
  t.hasSpaceBefore = a.hasSpaceBefore;
  t.isFirstOfLine = a.isFirstOfLine;
  return t;
}

Token Preprocessor::stringOf(const std::vector<Token>& tokens, const Token& at) {
  std::string s = "\"";
  for (size_t i = 0; i < tokens.size(); ++i) {
    if (i > 0 && (tokens[i].hasSpaceBefore || tokens[i].isFirstOfLine)) s += ' ';
    for (const char c : tokens[i].text) {
      if ((c == '"' || c == '\\') && tokens[i].kind == Token::Kind::String) s += '\\';
      s += c;
    }
  }
  work_ += s.size() / 8;
  if (work_ > kMostWork) messages_.fatal(at.pos, "macros expand to more than the compiler takes");
  Token t = at;
  t.kind = Token::Kind::String;
  t.punct = Punct::None;
  t.text = pool_.copy(s + "\"");
  return t;
}

}  // namespace kinora::language::front
