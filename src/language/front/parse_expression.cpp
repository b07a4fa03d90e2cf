// Expressions, by precedence as in C.
#include <algorithm>
#include <charconv>
#include <cstdlib>

#include "language/front/lexer.h"
#include "language/front/parser.h"

namespace kinora::language::front {

namespace {

int precedence(const Token& t) {
  if (const int p = precedence(t.punct)) return p;
  if (t.name == Name(Keyword::k_or)) return 1;
  return t.name == Name(Keyword::k_and) ? 2 : 0;
}

bool isAssign(Punct p) { return p >= Punct::Assign && p <= Punct::ShiftRightAssign; }

}  // namespace

Expr* Parser::make(ExprKind kind, Pos pos) {
  auto* e = pool_.make<Expr>();
  e->kind = kind;
  e->pos = pos;
  return e;
}

Expr* Parser::finish(Expr* e) {
  uint32_t below = 0;
  for (const Expr* child : {e->a, e->b, e->c})
    if (child) below = std::max<uint32_t>(below, child->depth);
  for (const Expr* child : e->list) below = std::max<uint32_t>(below, child->depth);
  if (below >= kMostTreeDepth) messages_.fatal(e->pos, "the expression is nested too deeply; split it");
  e->depth = uint16_t(below + 1);
  return e;
}

Expr* Parser::expression() {
  Expr* first = assignment();
  if (!is(Punct::Comma)) return first;
  Expr* e = make(ExprKind::Comma, first->pos);
  std::vector<Expr*> elements = {first};
  while (take(Punct::Comma)) elements.push_back(assignment());
  e->list = pool_.copy(elements);
  return finish(e);
}

Expr* Parser::assignment() {
  const Deeper deeper(*this);
  return assigned(ternary());
}

// What an assignment operator stands behind is its target.
Expr* Parser::assigned(Expr* target) {
  const Token& t = peek();
  if (!isAssign(t.punct)) return target;
  ++at_;
  Expr* e = make(ExprKind::Assign, t.pos);
  e->op = t.punct;
  e->a = target;
  e->b = initialiser();
  return finish(e);
}

Expr* Parser::ternary() {
  Expr* condition = binary(0);
  if (!is(Punct::Question)) return condition;
  const Deeper deeper(*this);
  Expr* e = make(ExprKind::Ternary, peek().pos);
  ++at_;
  e->a = condition;
  e->b = is(Punct::LBrace) ? list() : expression();
  expect(Punct::Colon, ":", "in '? :'");
  e->c = is(Punct::LBrace) ? list() : assignment();
  return finish(e);
}

Expr* Parser::binary(int above) {
  Expr* a = unary();
  for (;;) {
    const Token& t = peek();
    const int p = precedence(t);
    if (p <= above) return a;
    ++at_;
    Expr* e = make(ExprKind::Binary, t.pos);
    e->op = t.punct != Punct::None ? t.punct : t.name == Name(Keyword::k_or) ? Punct::OrOr : Punct::AndAnd;
    e->a = a;
    e->b = binary(p);
    a = finish(e);
  }
}

Expr* Parser::unary() {
  const Token& t = peek();
  const bool isNot = t.name == Name(Keyword::k_not);
  if (isNot || t.punct == Punct::Minus || t.punct == Punct::Plus || t.punct == Punct::Not ||
      t.punct == Punct::Tilde) {
    const Deeper deeper(*this);
    ++at_;
    Expr* e = make(ExprKind::Unary, t.pos);
    e->op = isNot ? Punct::Not : t.punct;
    e->a = unary();
    return finish(e);
  }
  if (t.punct == Punct::Increment || t.punct == Punct::Decrement) {
    const Deeper deeper(*this);
    ++at_;
    Expr* e = make(ExprKind::Increment, t.pos);
    e->op = t.punct;
    e->isPrefix = true;
    e->a = unary();
    return finish(e);
  }
  if (t.punct == Punct::LParen && peek(1).kind == Token::Kind::Identifier && isTypeKeyword(peek(1).name) &&
      (peek(2).punct == Punct::RParen || peek(1).name == Name(Keyword::k_closure))) {
    const Deeper deeper(*this);
    ++at_;
    Expr* e = make(ExprKind::Cast, t.pos);
    e->spec = type();
    expect(Punct::RParen, ")", "after the type");
    e->a = is(Punct::LBrace) ? list() : unary();
    return finish(e);
  }
  return postfix();
}

Expr* Parser::postfix() {
  Expr* e = primary();
  for (;;) {
    const Token& t = peek();
    if (t.punct == Punct::LBracket && peek(1).punct != Punct::LBracket) {  // [[ begins metadata
      ++at_;
      Expr* index = make(ExprKind::Index, t.pos);
      index->a = e;
      index->b = expression();
      expect(Punct::RBracket, "]", "after the index");
      e = finish(index);
    } else if (t.punct == Punct::Dot) {
      ++at_;
      Expr* field = make(ExprKind::Field, peek().pos);
      if (peek().kind != Token::Kind::Identifier) wrong(peek(), "expected the name of a field, found " + found());
      field->name = peek().name;
      ++at_;
      field->a = e;
      e = finish(field);
    } else if (t.punct == Punct::Increment || t.punct == Punct::Decrement) {
      ++at_;
      Expr* increment = make(ExprKind::Increment, t.pos);
      increment->op = t.punct;
      increment->a = e;
      e = finish(increment);
    } else {
      // an assignment binds to what stands before it wherever that can be written to: +r = 3 is +(r = 3)
      const bool isPlace = e->kind == ExprKind::Variable || e->kind == ExprKind::Index || e->kind == ExprKind::Field;
      if (!isPlace || e->isParenthesised || !isAssign(t.punct)) return e;
      const Deeper deeper(*this);
      return assigned(e);
    }
  }
}

std::span<Expr*> Parser::arguments() {
  std::vector<Expr*> list;
  if (take(Punct::RParen)) return {};
  do list.push_back(initialiser());
  while (take(Punct::Comma));
  expect(Punct::RParen, ")", "after the arguments");
  return pool_.copy(list);
}

Expr* Parser::list() {
  const Deeper deeper(*this);
  Expr* e = make(ExprKind::List, peek().pos);
  ++at_;
  std::vector<Expr*> elements;
  while (!is(Punct::RBrace)) {
    elements.push_back(initialiser());
    if (!take(Punct::Comma)) break;
  }
  if (elements.empty() && !isInFormals_) {
    messages_.error(e->pos, "only defaults of shader parameters may be an empty list");
    e->kind = ExprKind::Bad;
  }
  expect(Punct::RBrace, "}", "after the list");
  e->list = pool_.copy(elements);
  return finish(e);
}

Expr* Parser::primary() {
  const Token& t = peek();
  switch (t.kind) {
    case Token::Kind::Number:
      return number();
    case Token::Kind::String: {
      Expr* e = make(ExprKind::String, t.pos);
      std::string text;
      while (peek().kind == Token::Kind::String) {  // strings side by side are one
        std::string badEscape;
        text += unescaped(peek().text, badEscape);
        if (!badEscape.empty()) messages_.warning(peek().pos, "unknown escape '" + badEscape + "' in a string");
        ++at_;
      }
      e->text = pool_.copy(text);
      return e;
    }
    case Token::Kind::Punct:
      if (t.punct == Punct::LParen) {
        ++at_;
        Expr* e = expression();
        expect(Punct::RParen, ")", "after the expression");
        if (e->kind == ExprKind::Comma && !e->isParenthesised)
          messages_.warning(e->pos,
                            "a comma in parentheses gives the last value alone; color(...) or {...} is meant?");
        e->isParenthesised = true;
        return e;
      }
      break;
    case Token::Kind::Identifier: {
      if (isTypeKeyword(t.name) && t.name != Name(Keyword::k_void)) {
        Expr* e = make(ExprKind::Construct, t.pos);
        e->spec = type();
        expect(Punct::LParen, "(", "after the type");
        e->list = arguments();
        return finish(e);
      }
      if (t.name < Name(Keyword::Count)) {
        if (t.name == Name(Keyword::k_illuminance) || t.name == Name(Keyword::k_illuminate))
          wrong(t, "'" + std::string(t.text) + "' is not supported");
        wrong(t, "expected an expression, found the reserved word '" + std::string(t.text) + "'");
      }
      ++at_;
      Expr* e = make(is(Punct::LParen) ? ExprKind::Call : ExprKind::Variable, t.pos);
      e->name = t.name;
      if (take(Punct::LParen)) e->list = arguments();
      return finish(e);
    }
    default:
      break;
  }
  wrong(t, "expected an expression, found " + found());
}

Expr* Parser::number() {
  const Token& t = peek();
  ++at_;
  std::string_view s = t.text;
  const bool isHex = s.size() > 2 && s[0] == '0' && (s[1] | 32) == 'x';
  const bool isFloat = !isHex && s.find_first_of(".eE") != std::string_view::npos;
  if (!isFloat) {
    Expr* e = make(ExprKind::Int, t.pos);
    if (isHex) s.remove_prefix(2);
    uint64_t v = 0;
    const auto [end, error] = std::from_chars(s.data(), s.data() + s.size(), v, isHex ? 16 : 10);
    if (end == s.data() + s.size() - 1 && (*end | 32) == 'f' && !isHex) {  // 1f
      e->kind = ExprKind::Float;
      e->floatValue = float(v);
      return e;
    }
    if (end != s.data() + s.size()) wrong(t, "'" + std::string(t.text.substr(0, 40)) + "' is no number");
    // 2^31 itself can only be meant with a minus before it
    if (error != std::errc() || v > (isHex ? 0xffffffffu : 0x80000000u))
      messages_.error(t.pos, "the number " + std::string(t.text.substr(0, 40)) + " does not fit into an int");
    e->intValue = int32_t(uint32_t(v));
    e->isPrefix = isHex;  // 0x80000000 is as good as any
    return e;
  }
  Expr* e = make(ExprKind::Float, t.pos);
  float v = 0;
  const auto [end, error] = std::from_chars(s.data(), s.data() + s.size(), v);
  if (!(end == s.data() + s.size() || (end == s.data() + s.size() - 1 && (*end | 32) == 'f')))
    wrong(t, "'" + std::string(t.text.substr(0, 40)) + "' is no number");
  if (error == std::errc::result_out_of_range) v = std::strtof(std::string(s).c_str(), nullptr);  // 0 or infinity
  e->floatValue = v;
  return e;
}

}  // namespace kinora::language::front
