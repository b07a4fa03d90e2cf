// Files and directives; macros.cpp expands, condition.cpp evaluates #if.
#include "language/front/preprocessor.h"

#include "language/front/prelude.h"

namespace kinora::language::front {

namespace {

constexpr size_t kMostTokens = 6'000'000;
constexpr size_t kMostOpenFiles = 100;  // of includes; the same for #if inside #if, times ten
constexpr uint32_t kMostIncludes = 5000;

}  // namespace

Preprocessor::Preprocessor(const CompileOptions& options, const FileReader& reader, Pool& pool, Names& names,
                           Messages& messages)
    : options_(options),
      reader_(reader),
      pool_(pool),
      names_(names),
      messages_(messages),
      defined_(names.intern("defined")),
      vaArgs_(names.intern("__VA_ARGS__")) {}

Preprocessor::Macro* Preprocessor::macroOf(Name name) {
  return name < byName_.size() && byName_[name] && byName_[name]->isDefined ? byName_[name] : nullptr;
}

std::vector<Token> Preprocessor::run(const std::string& name, std::string_view source) {
  std::string commandLine;
  for (std::string d : options_.defines) {
    const size_t equal = d.find('=');
    if (equal != std::string::npos)
      d[equal] = ' ';
    else
      d += " 1";
    for (char& c : d) c = c == '\n' ? ' ' : c;
    commandLine += "#define " + d + "\n";
  }
  for (const std::string& u : options_.undefines) commandLine += "#undef " + u.substr(0, u.find('\n')) + "\n";
  // includes stand on a stack: what is read first is pushed last
  filesRead_.push_back(name);
  for (auto [own, text] :
       {std::pair<const char*, Macro::Own>{"__FILE__", Macro::Own::File}, {"__LINE__", Macro::Own::Line}}) {
    const Name n = names_.intern(own);
    if (byName_.size() <= n) byName_.resize(n + 1);
    macros_.emplace_back().own = text;
    macros_.back().isDefined = true;
    byName_[n] = &macros_.back();
  }
  read(name, std::string(source), {});
  if (!commandLine.empty()) read("<command line>", commandLine, {});
  read("<built-in>", std::string(preludeMacros()), {});
  std::vector<Token> tokens;
  tokens.reserve(source.size() / 4 + 16);
  for (;;) {
    tokens.push_back(expanded());
    if (tokens.back().kind == Token::Kind::End) break;
    if (tokens.back().kind == Token::Kind::Bad) {
      messages_.error(tokens.back().pos, "unexpected character '" + std::string(tokens.back().text) + "'");
      tokens.pop_back();
    }
    if (tokens.size() > kMostTokens) messages_.fatal(tokens.back().pos, "the source is too large");
  }
  return tokens;
}

void Preprocessor::read(const std::string& path, std::string text, Pos includedAt) {
  const uint16_t file = messages_.addFile(path, std::move(text));
  files_.push_back({Lexer(messages_.text(file), file, names_, messages_), path, conditions_.size(), includedAt});
}

Token Preprocessor::fileToken() {
  for (;;) {
    Token t = files_.back().lexer.next();
    if (t.kind == Token::Kind::Punct && t.punct == Punct::Hash && t.isFirstOfLine) {
      directive(t);
      continue;
    }
    if (t.kind != Token::Kind::End) return t;
    while (conditions_.size() > files_.back().conditions) {
      messages_.error(conditions_.back().pos, "this condition has no #endif");
      conditions_.pop_back();
    }
    if (files_.size() == 1) return t;
    files_.pop_back();
  }
}

std::vector<Token> Preprocessor::restOfLine() {
  std::vector<Token> tokens;
  Token t;
  while (files_.back().lexer.nextInLine(t)) tokens.push_back(t);
  return tokens;
}

void Preprocessor::endOfLine(const char* directive) {
  Token t;
  if (files_.back().lexer.nextInLine(t)) {
    messages_.warning(t.pos, std::string("extra text after #") + directive);
    files_.back().lexer.skipLine();
  }
}

void Preprocessor::directive(const Token& hash) {
  Lexer& lexer = files_.back().lexer;
  Token t;
  if (!lexer.nextInLine(t)) return;                            // # alone
  if (t.kind == Token::Kind::Number) return lexer.skipLine();  // a line marker of another preprocessor
  const std::string_view name = t.text;
  if (name == "define") return define(t);
  if (name == "include") return include(t);
  if (name == "pragma") return pragma(t);
  if (name == "if") return beginCondition(t, condition(t));
  if (name == "ifdef" || name == "ifndef") {
    Token m;
    bool isDefined = false;
    if (!lexer.nextInLine(m) || m.kind != Token::Kind::Identifier) {
      messages_.error(t.pos, "#" + std::string(name) + " needs a name");
      lexer.skipLine();
    } else {
      isDefined = macroOf(m.name) != nullptr;
      endOfLine("ifdef");
    }
    return beginCondition(t, isDefined == (name == "ifdef"));
  }
  if (name == "else" || name == "elif" || name == "endif") {
    if (conditions_.size() <= files_.back().conditions) {
      messages_.error(t.pos, "#" + std::string(name) + " without #if");
      return lexer.skipLine();
    }
    if (name == "endif") {
      conditions_.pop_back();
      return endOfLine("endif");
    }
    // reached by reading the group before: it was taken
    if (conditions_.back().hasElse) messages_.error(t.pos, "#" + std::string(name) + " after #else");
    if (name == "else") conditions_.back().hasElse = true;
    lexer.skipLine();
    return skipGroup(false);
  }
  if (name == "undef") {
    Token m;
    if (!lexer.nextInLine(m) || m.kind != Token::Kind::Identifier) {
      messages_.error(t.pos, "#undef needs a name");
      return lexer.skipLine();
    }
    if (Macro* macro = macroOf(m.name)) macro->isDefined = false;
    return endOfLine("undef");
  }
  if (name == "error" || name == "warning") return message(t, name == "error");
  if (name == "line") return lexer.skipLine();
  messages_.error(hash.pos, "unknown directive #" + std::string(name));
  lexer.skipLine();
}

void Preprocessor::message(const Token& at, bool isError) {
  std::string text;
  for (const Token& t : restOfLine()) {
    if (t.hasSpaceBefore && !text.empty()) text += ' ';
    std::string ignored;
    text += t.kind == Token::Kind::String ? unescaped(t.text, ignored) : std::string(t.text);
  }
  if (isError)
    messages_.error(at.pos, "#error " + text);
  else
    messages_.warning(at.pos, "#warning " + text);
}

void Preprocessor::pragma(const Token& at) {
  Token t;
  if (!files_.back().lexer.nextInLine(t)) return;
  if (t.text == "once")
    once_.insert(files_.back().path);
  else if (t.text == "error" || t.text == "warning")
    return message(at, t.text == "error");
  else if (t.text != "osl")
    messages_.warning(t.pos, "unknown pragma '" + std::string(t.text) + "'");
  else if (files_.back().lexer.nextInLine(t) && t.text == "nowarn")
    messages_.keepQuiet(at.pos.file, at.pos.line + 1);
  files_.back().lexer.skipLine();  // what else #pragma osl says is for tools
}

void Preprocessor::define(const Token& at) {
  Lexer& lexer = files_.back().lexer;
  Token name;
  if (!lexer.nextInLine(name) || name.kind != Token::Kind::Identifier) {
    messages_.error(at.pos, "#define needs a name");
    return lexer.skipLine();
  }
  if (name.name == defined_) {
    messages_.error(name.pos, "'defined' cannot be a macro");
    return lexer.skipLine();
  }
  Macro macro;
  macro.isDefined = true;
  macro.body = restOfLine();
  if (!macro.body.empty() && macro.body[0].punct == Punct::LParen && !macro.body[0].hasSpaceBefore) {
    macro.isFunction = true;
    size_t i = 1;
    bool isGood = i < macro.body.size();
    while (isGood && macro.body[i].punct != Punct::RParen) {
      const Token& p = macro.body[i];
      if (p.punct == Punct::Ellipsis) {
        macro.isVariadic = true;
        macro.parameters.push_back(vaArgs_);
      } else if (p.kind == Token::Kind::Identifier) {
        macro.parameters.push_back(p.name);
      } else {
        isGood = false;
        break;
      }
      if (++i >= macro.body.size()) isGood = false;
      if (isGood && macro.body[i].punct == Punct::Comma && !macro.isVariadic && i + 1 < macro.body.size() &&
          macro.body[i + 1].punct != Punct::RParen)
        ++i;
      else if (isGood && macro.body[i].punct != Punct::RParen)
        isGood = false;
    }
    if (!isGood || macro.parameters.size() > 200) {
      messages_.error(name.pos, "the parameters of macro '" + std::string(name.text) + "' make no sense");
      return;
    }
    macro.body.erase(macro.body.begin(), macro.body.begin() + long(i) + 1);
  }
  if (!macro.body.empty()) macro.body[0].hasSpaceBefore = false;
  if (!macro.body.empty() &&
      (macro.body.front().punct == Punct::HashHash || macro.body.back().punct == Punct::HashHash)) {
    messages_.error(name.pos, "## cannot stand at an end of a macro");
    return;
  }
  if (byName_.size() <= name.name) byName_.resize(name.name + 64);
  if (const Macro* old = macroOf(name.name)) {
    bool isSame = old->own == Macro::Own::No && old->isFunction == macro.isFunction &&
                  old->parameters == macro.parameters && old->body.size() == macro.body.size();
    for (size_t i = 0; isSame && i < macro.body.size(); ++i) isSame = old->body[i].text == macro.body[i].text;
    if (!isSame) messages_.warning(name.pos, "macro '" + std::string(name.text) + "' is defined again");
  }
  macros_.push_back(std::move(macro));  // an expansion of the old one may still be read: it stays
  byName_[name.name] = &macros_.back();
}

void Preprocessor::include(const Token& at) {
  std::vector<Token> rest = restOfLine();
  if (!rest.empty() && rest[0].kind == Token::Kind::Identifier) rest = expandedAlone(rest);
  std::string name;
  bool isAngle = false, isGood = false;
  if (rest.size() == 1 && rest[0].kind == Token::Kind::String) {
    name = rest[0].text.substr(1, rest[0].text.size() - 2);
    isGood = true;
  } else if (rest.size() > 2 && rest[0].punct == Punct::Less && rest.back().punct == Punct::Greater) {
    isAngle = isGood = true;
    for (size_t i = 1; i + 1 < rest.size(); ++i)
      name += (rest[i].hasSpaceBefore && i > 1 ? " " : "") + std::string(rest[i].text);
  }
  if (!isGood || name.empty()) return messages_.error(at.pos, "#include needs \"FILE\" or <FILE>");
  const Pos pos = rest[0].pos;
  if (files_.size() >= kMostOpenFiles)
    messages_.fatal(pos, "includes are nested more than " + std::to_string(kMostOpenFiles) + " deep: does \"" + name +
                             "\" include itself?");
  if (++included_ > kMostIncludes) messages_.fatal(pos, "more than " + std::to_string(kMostIncludes) + " includes");
  const size_t slash = name.rfind('/');
  if (std::string_view(name).substr(slash == std::string::npos ? 0 : slash + 1) == "stdosl.h") return;  // built in

  std::vector<std::string> candidates;
  if (name[0] == '/') {
    candidates.push_back(name);
  } else {
    if (!isAngle) {
      const std::string& here = files_.back().path;
      const size_t end = here.rfind('/');
      candidates.push_back((end == std::string::npos ? "" : here.substr(0, end + 1)) + name);
    }
    for (const std::string& path : options_.includePaths)
      candidates.push_back(path.empty() || path.back() == '/' ? path + name : path + "/" + name);
  }
  for (const std::string& path : candidates) {
    if (once_.contains(path)) return;
    if (std::optional<std::string> text = reader_(path)) {
      filesRead_.push_back(path);
      return read(path, std::move(*text), pos);
    }
  }
  if (const std::string_view text = preludeHeader(name); !text.empty()) {
    if (once_.insert("<" + name + ">").second) read("<" + name + ">", std::string(text), pos);
    return;
  }
  messages_.error(pos,
                  "cannot find \"" + name + "\"" + (options_.includePaths.empty() ? "; no -I path is given" : ""));
}

void Preprocessor::beginCondition(const Token& at, bool isTrue) {
  if (conditions_.size() >= kMostOpenFiles * 10) messages_.fatal(at.pos, "conditions are nested too deeply");
  conditions_.push_back({isTrue, false, at.pos});
  if (!isTrue) skipGroup(true);
}

// Skips to the #else or #elif that holds (`toElse`), or to the #endif.
void Preprocessor::skipGroup(bool toElse) {
  Lexer& lexer = files_.back().lexer;
  size_t depth = 0;
  for (;;) {
    Token t;
    if (!lexer.atHash()) {
      if (lexer.atEnd()) return;  // fileToken() reports it
      lexer.skipLine();
      continue;
    }
    lexer.next();
    if (!lexer.nextInLine(t)) continue;
    if (t.text == "if" || t.text == "ifdef" || t.text == "ifndef") {
      ++depth;
    } else if (t.text == "endif") {
      if (depth == 0) {
        conditions_.pop_back();
        return endOfLine("endif");
      }
      --depth;
    } else if ((t.text == "else" || t.text == "elif") && depth == 0) {
      Condition& c = conditions_.back();
      if (c.hasElse) messages_.error(t.pos, "#" + std::string(t.text) + " after #else");
      if (t.text == "else") {
        c.hasElse = true;
        if (toElse && !c.isTaken) {
          c.isTaken = true;
          return endOfLine("else");
        }
      } else if (toElse && !c.isTaken && condition(t)) {
        c.isTaken = true;
        return;
      }
    }
    lexer.skipLine();
  }
}

std::string textOf(const std::vector<Token>& tokens, const Messages& messages) {
  std::string s;
  uint32_t line = 1, file = UINT32_MAX;
  for (const Token& t : tokens) {
    if (t.kind == Token::Kind::End) break;
    if (t.pos.file != file || t.pos.line < line || t.pos.line > line + 8) {
      if (!s.empty() && s.back() != '\n') s += '\n';
      s += "# " + std::to_string(t.pos.line) + " \"" + messages.nameOf(t.pos.file) + "\"\n";
      file = t.pos.file;
      line = t.pos.line;
    }
    while (line < t.pos.line) {
      s += '\n';
      ++line;
    }
    if (s.empty() || s.back() == '\n')
      s.append(t.pos.column > 1 && t.pos.column < 200 ? t.pos.column - 1 : 0, ' ');
    else
      s += ' ';
    s += t.text;
    for (const char c : t.text) line += c == '\n';
  }
  return s + "\n";
}

}  // namespace kinora::language::front
