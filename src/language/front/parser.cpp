#include "language/front/parser.h"

namespace kinora::language::front {

std::string Parser::found() const {
  const Token& t = peek();
  if (t.kind == Token::Kind::End) return "the end of the file";
  return "'" + std::string(t.text.substr(0, 40)) + "'";
}

void Parser::wrong(const Token& at, std::string text) {
  messages_.error(at.pos, std::move(text));
  throw SyntaxError{};
}

void Parser::expect(Punct p, const char* what, const char* where) {
  if (take(p)) return;
  // a missing ; belongs to the end of the line before
  if (p == Punct::Semicolon && at_ > 0 && peek().isFirstOfLine) {
    const Token& last = tokens_[at_ - 1];
    Pos pos = last.pos;
    if (pos.column) pos.column = uint16_t(pos.column + std::min<size_t>(last.text.size(), 60000));
    messages_.error(pos, std::string("expected '") + what + "' " + where);
    throw SyntaxError{};
  }
  wrong(peek(), std::string("expected '") + what + "' " + where + ", found " + found());
}

const Token& Parser::identifier(const char* what) {
  const Token& t = peek();
  if (t.kind != Token::Kind::Identifier) wrong(t, std::string("expected ") + what + ", found " + found());
  if (t.name < Name(Keyword::Count))
    wrong(t, "'" + std::string(t.text) + "' is a reserved word and cannot be " + what);
  ++at_;
  return t;
}

bool Parser::startsType() const {
  const Token& t = peek();
  return t.kind == Token::Kind::Identifier && (isTypeKeyword(t.name) || t.name == Name(Keyword::k_struct));
}

bool Parser::startsDeclaration() const {
  if (startsType()) return peek(1).punct != Punct::LParen;
  const Token &a = peek(), &b = peek(1);
  const auto isName = [](const Token& t) {
    return t.kind == Token::Kind::Identifier && t.name >= Name(Keyword::Count);
  };
  const bool isForeign =
      a.kind == Token::Kind::Identifier && a.name >= kFirstReserved && a.name < Name(Keyword::Count);
  return (isName(a) || isForeign) && isName(b);  // `bool x`: type() says what is wrong with it
}

bool Parser::startsItem() const {
  const Token& t = peek();
  const bool isFirst = t.kind == Token::Kind::Identifier && (t.name >= Name(Keyword::Count) || startsType());
  return isFirst && t.isFirstOfLine && peek(1).kind == Token::Kind::Identifier &&
         (peek(2).punct == Punct::LParen || peek(2).punct == Punct::LBrace ||
          (peek(2).punct == Punct::LBracket && peek(3).punct == Punct::LBracket));
}

// Behind the next ; or a block that closes, before the } of the block around.
void Parser::recover() {
  int depth = 0;
  for (; peek().kind != Token::Kind::End; ++at_) {
    if (is(Punct::LBrace)) ++depth;
    if (is(Punct::RBrace)) {
      if (depth == 0) return;
      if (--depth == 0) {
        ++at_;
        return;
      }
    }
    if (is(Punct::Semicolon) && depth == 0) {
      ++at_;
      return;
    }
  }
}

Program Parser::run() {
  Program program;
  while (peek().kind != Token::Kind::End) {
    const size_t before = at_;
    try {
      item(program);
    } catch (const SyntaxError&) {
      depth_ = 0;
      if (at_ == before) ++at_;
      // on to what may be the beginning of an item: the rest of a broken one is no news
      while (peek().kind != Token::Kind::End && !startsItem()) {
        const size_t here = at_;
        recover();
        if (at_ == here) ++at_;
      }
    }
  }
  return program;
}

void Parser::item(Program& program) {
  if (take(Punct::Semicolon)) return;
  if (is(Keyword::k_struct) && peek(2).punct == Punct::LBrace) {
    program.items.push_back({nullptr, structure(), nullptr});
    return;
  }
  const Token& first = peek();
  if (first.kind == Token::Kind::Identifier && !isTypeKeyword(first.name) &&
      peek(1).kind == Token::Kind::Identifier &&
      (peek(2).punct == Punct::LParen || peek(2).punct == Punct::LBracket)) {
    ShaderKind kind = ShaderKind::Shader;
    bool isShader = true;
    if (first.text == "surface")
      kind = ShaderKind::Surface;
    else if (first.text == "displacement")
      kind = ShaderKind::Displacement;
    else if (first.text == "volume")
      kind = ShaderKind::Volume;
    else if (first.text == "light")
      kind = ShaderKind::Surface;  // of old: what lights are shaded by is a surface now
    else if (first.text != "shader")
      isShader = false;
    if (isShader) {
      ++at_;
      program.items.push_back({nullptr, nullptr, shader(kind)});
      return;
    }
  }
  if (!startsDeclaration()) wrong(first, "expected a shader, a function or a struct, found " + found());
  const TypeSpec spec = type();
  const Token& name = identifier("a name");
  if (!is(Punct::LParen)) wrong(name, "variables cannot be declared outside of functions and shaders");
  program.items.push_back({function(spec, name), nullptr, nullptr});
}

ShaderDecl* Parser::shader(ShaderKind kind) {
  auto* s = pool_.make<ShaderDecl>();
  s->kind = kind;
  const Token& name = identifier("the name of a shader");
  s->name = name.name;
  s->pos = name.pos;
  s->metadata = metadata();
  expect(Punct::LParen, "(", "before the parameters");
  s->parameters = pool_.copy(formals(true));
  const auto more = metadata();
  if (!more.empty()) s->metadata = more;
  if (!is(Punct::LBrace)) wrong(peek(), "expected the shader's body, found " + found());
  s->body = block();
  return s;
}

StructDecl* Parser::structure() {
  auto* s = pool_.make<StructDecl>();
  ++at_;
  const Token& name = identifier("the name of a struct");
  s->name = name.name;
  s->pos = name.pos;
  expect(Punct::LBrace, "{", "after the name of the struct");
  std::vector<Var*> fields;
  while (!take(Punct::RBrace)) {
    const TypeSpec spec = type();
    do {
      auto* f = pool_.make<Var>();
      const Token& t = identifier("the name of a field");
      f->name = t.name;
      f->pos = t.pos;
      f->spec = spec;
      arrayLength(f->spec);
      if (is(Punct::Assign)) wrong(peek(), "fields of a struct have no default");
      fields.push_back(f);
    } while (take(Punct::Comma));
    expect(Punct::Semicolon, ";", "after the field");
  }
  s->fields = pool_.copy(fields);
  expect(Punct::Semicolon, ";", "after the struct");
  return s;
}

Function* Parser::function(const TypeSpec& spec, const Token& name) {
  auto* f = pool_.make<Function>();
  f->name = name.name;
  f->pos = name.pos;
  f->spec = spec;
  expect(Punct::LParen, "(", "before the parameters");
  f->parameters = pool_.copy(formals(false));
  f->metadata = metadata();
  if (take(Punct::Semicolon)) return f;
  if (!is(Punct::LBrace)) wrong(peek(), "expected the function's body, found " + found());
  f->body = block();
  return f;
}

std::vector<Var*> Parser::formals(bool isShader) {
  std::vector<Var*> list;
  if (take(Punct::RParen)) return list;
  isInFormals_ = isShader;
  if (is(Keyword::k_void) && peek(1).punct == Punct::RParen) {
    at_ += 2;
    return list;
  }
  do {
    if (is(Punct::RParen) && !list.empty()) break;  // a comma after the last
    auto* v = pool_.make<Var>();
    v->isOutput = take(Keyword::k_output);
    if (!startsDeclaration()) wrong(peek(), "expected a parameter, found " + found());
    v->spec = type();
    const Token& name = identifier("the name of a parameter");
    v->name = name.name;
    v->pos = name.pos;
    arrayLength(v->spec);
    if (is(Punct::Assign)) {
      const Token& equal = peek();
      ++at_;
      v->init = initialiser();
      if (!isShader) messages_.error(equal.pos, "parameters of functions have no default");
    }
    v->metadata = metadata();
    list.push_back(v);
  } while (takeCommas());
  isInFormals_ = false;
  expect(Punct::RParen, ")", "after the parameters");
  return list;
}

std::span<MetaDecl> Parser::metadata() {
  std::vector<MetaDecl> list;
  if (!is(Punct::LBracket) || peek(1).punct != Punct::LBracket) return {};
  at_ += 2;
  while (!is(Punct::RBracket)) {
    MetaDecl m;
    m.spec = type();
    const Token& t = peek();
    if (t.kind != Token::Kind::Identifier) wrong(t, "expected the name of metadata, found " + found());
    ++at_;
    m.name = t.name;
    m.pos = t.pos;
    arrayLength(m.spec);
    expect(Punct::Assign, "=", "after the name of metadata");
    m.value = initialiser();
    list.push_back(m);
    if (!takeCommas()) break;
  }
  expect(Punct::RBracket, "]]", "after the metadata");
  expect(Punct::RBracket, "]]", "after the metadata");
  return pool_.copy(list);
}

TypeSpec Parser::type() {
  TypeSpec spec;
  const Token& t = peek();
  spec.pos = t.pos;
  if (t.kind != Token::Kind::Identifier) wrong(t, "expected a type, found " + found());
  ++at_;
  switch (Keyword(t.name)) {
    case Keyword::k_int:
      spec.base = Base::Int;
      return spec;
    case Keyword::k_float:
      spec.base = Base::Float;
      return spec;
    case Keyword::k_string:
      spec.base = Base::String;
      return spec;
    case Keyword::k_color:
      spec.base = Base::Color;
      return spec;
    case Keyword::k_point:
      spec.base = Base::Point;
      return spec;
    case Keyword::k_vector:
      spec.base = Base::Vector;
      return spec;
    case Keyword::k_normal:
      spec.base = Base::Normal;
      return spec;
    case Keyword::k_matrix:
      spec.base = Base::Matrix;
      return spec;
    case Keyword::k_void:
      return spec;
    case Keyword::k_closure:
      if (!take(Keyword::k_color)) wrong(peek(), "expected 'color' after 'closure', found " + found());
      spec.base = Base::Closure;
      return spec;
    case Keyword::k_struct:
      break;
    default:
      --at_;
  }
  const Token& name = peek();
  if (name.kind == Token::Kind::Identifier && name.name >= kFirstReserved && name.name < Name(Keyword::Count))
    wrong(name, "there is no type '" + std::string(name.text) + "'" +
                    (name.text == "bool"     ? "; use int"
                     : name.text == "double" ? "; use float"
                                             : ""));
  spec.base = Base::Struct;
  spec.structName = identifier("a type").name;
  return spec;
}

void Parser::arrayLength(TypeSpec& spec) {
  if (!is(Punct::LBracket) || peek(1).punct == Punct::LBracket) return;
  ++at_;
  if (take(Punct::RBracket)) {
    spec.isUnsized = true;
  } else {
    spec.length = ternary();
    expect(Punct::RBracket, "]", "after the length of the array");
  }
  if (is(Punct::LBracket) && peek(1).punct != Punct::LBracket) wrong(peek(), "there are no arrays of arrays");
}

Expr* Parser::initialiser() { return is(Punct::LBrace) ? list() : assignment(); }

Stmt* Parser::block() {
  const Deeper deeper(*this);
  auto* s = pool_.make<Stmt>();
  s->kind = StmtKind::Block;
  s->pos = peek().pos;
  const Token& open = peek();
  ++at_;
  std::vector<Stmt*> list;
  while (!take(Punct::RBrace)) {
    if (peek().kind == Token::Kind::End) wrong(open, "this '{' is never closed");
    const uint32_t depth = depth_;
    try {
      list.push_back(statement());
    } catch (const SyntaxError&) {
      depth_ = depth;
      recover();
      if (peek().kind == Token::Kind::End) throw;
    }
  }
  s->list = pool_.copy(list);
  return s;
}

Stmt* Parser::declaration() {
  auto* s = pool_.make<Stmt>();
  s->pos = peek().pos;
  if (is(Keyword::k_struct) && peek(2).punct == Punct::LBrace) {
    s->kind = StmtKind::Struct;
    s->structure = structure();
    return s;
  }
  const TypeSpec spec = type();
  if (peek(1).punct == Punct::LParen) {
    const Token& name = identifier("the name of a function");
    s->kind = StmtKind::Function;
    s->function = function(spec, name);
    return s;
  }
  s->kind = StmtKind::Variables;
  std::vector<Var*> vars;
  do {
    auto* v = pool_.make<Var>();
    const Token& name = identifier("the name of a variable");
    v->name = name.name;
    v->pos = name.pos;
    v->spec = spec;
    arrayLength(v->spec);
    if (take(Punct::Assign)) v->init = initialiser();
    vars.push_back(v);
  } while (take(Punct::Comma));
  expect(Punct::Semicolon, ";", "after the declaration");
  s->vars = pool_.copy(vars);
  return s;
}

Stmt* Parser::ifStatement(Stmt* s) {
  s->kind = StmtKind::If;
  expect(Punct::LParen, "(", "after 'if'");
  s->expr = expression();
  expect(Punct::RParen, ")", "after the condition");
  s->body = statement();
  if (take(Keyword::k_else)) s->other = statement();
  return s;
}

Stmt* Parser::forStatement(Stmt* s) {
  s->kind = StmtKind::For;
  expect(Punct::LParen, "(", "after 'for'");
  if (startsDeclaration()) {
    s->init = declaration();
    if (s->init->kind != StmtKind::Variables) wrong(peek(), "expected a variable or an expression before ';'");
  } else {
    s->init = pool_.make<Stmt>();
    s->init->pos = peek().pos;
    if (!is(Punct::Semicolon)) {
      s->init->kind = StmtKind::Expression;
      s->init->expr = expression();
    }
    expect(Punct::Semicolon, ";", "in 'for'");
  }
  if (!is(Punct::Semicolon)) s->expr = expression();
  expect(Punct::Semicolon, ";", "in 'for'");
  if (!is(Punct::RParen)) s->step = expression();
  expect(Punct::RParen, ")", "after 'for'");
  s->body = statement();
  return s;
}

Stmt* Parser::statement() {
  const Deeper deeper(*this);
  if (is(Punct::LBrace)) return block();
  if (startsDeclaration()) return declaration();
  auto* s = pool_.make<Stmt>();
  s->pos = peek().pos;
  if (take(Punct::Semicolon)) return s;
  if (peek().kind == Token::Kind::Identifier && peek().name < Name(Keyword::Count)) return simple(s);
  s->kind = StmtKind::Expression;
  s->expr = expression();
  expect(Punct::Semicolon, ";", "after the statement");
  return s;
}

// Statements that begin with a keyword.
Stmt* Parser::simple(Stmt* s) {
  switch (Keyword(peek().name)) {
    case Keyword::k_if:
      ++at_;
      return ifStatement(s);
    case Keyword::k_for:
      ++at_;
      return forStatement(s);
    case Keyword::k_while:
      ++at_;
      s->kind = StmtKind::While;
      expect(Punct::LParen, "(", "after 'while'");
      s->expr = expression();
      expect(Punct::RParen, ")", "after the condition");
      s->body = statement();
      return s;
    case Keyword::k_do:
      ++at_;
      s->kind = StmtKind::DoWhile;
      s->body = statement();
      if (!take(Keyword::k_while)) wrong(peek(), "expected 'while' after the body of 'do', found " + found());
      expect(Punct::LParen, "(", "after 'while'");
      s->expr = expression();
      expect(Punct::RParen, ")", "after the condition");
      break;
    case Keyword::k_break:
      ++at_;
      s->kind = StmtKind::Break;
      break;
    case Keyword::k_continue:
      ++at_;
      s->kind = StmtKind::Continue;
      break;
    case Keyword::k_return:
      ++at_;
      s->kind = StmtKind::Return;
      if (!is(Punct::Semicolon)) s->expr = is(Punct::LBrace) ? list() : expression();
      break;
    case Keyword::k_else:
      wrong(peek(), "'else' without 'if'");
    default:
      s->kind = StmtKind::Expression;
      s->expr = expression();
  }
  expect(Punct::Semicolon, ";", "after the statement");
  return s;
}

}  // namespace kinora::language::front
