// Tokens to a tree, by recursive descent. After a mistake it goes on behind the next ; or } so that one compilation
// shows several. Depth is bounded, so that no source overflows the stack.
#pragma once
#include "language/front/ast.h"

namespace kinora::language::front {

class Parser {
 public:
  Parser(std::span<const Token> tokens, Pool& pool, Names& names, Messages& messages)
      : tokens_(tokens), pool_(pool), names_(names), messages_(messages) {}
  Program run();

 private:
  struct SyntaxError {};
  struct Deeper;

  // parser.cpp: declarations and statements
  void item(Program& program);
  ShaderDecl* shader(ShaderKind kind);
  StructDecl* structure();
  Function* function(const TypeSpec& spec, const Token& name);
  std::vector<Var*> formals(bool isShader);
  std::span<MetaDecl> metadata();
  TypeSpec type();
  void arrayLength(TypeSpec& spec);
  Expr* initialiser();
  Stmt* block();
  Stmt* statement();
  Stmt* ifStatement(Stmt* s);
  Stmt* forStatement(Stmt* s);
  Stmt* declaration();
  Stmt* simple(Stmt* s);
  void recover();
  bool startsItem() const;
  bool startsType() const;
  bool startsDeclaration() const;

  // parse_expression.cpp
  Expr* expression();  // with commas
  Expr* assignment();
  Expr* assigned(Expr* target);
  Expr* ternary();
  Expr* binary(int above);
  Expr* unary();
  Expr* postfix();
  Expr* primary();
  Expr* number();
  Expr* list();
  std::span<Expr*> arguments();
  Expr* make(ExprKind kind, Pos pos);
  Expr* finish(Expr* e);

  const Token& peek(size_t ahead = 0) const {
    return tokens_[at_ + ahead < tokens_.size() ? at_ + ahead : tokens_.size() - 1];
  }
  bool is(Punct p) const { return peek().punct == p; }
  bool is(Keyword k) const { return peek().name == Name(k); }
  bool take(Punct p) { return is(p) && (++at_, true); }
  bool take(Keyword k) { return is(k) && (++at_, true); }
  bool takeCommas() {  // one or more, as the grammar of parameters and metadata has them
    if (!take(Punct::Comma)) return false;
    while (take(Punct::Comma)) {
    }
    return true;
  }
  void expect(Punct p, const char* what, const char* where);
  const Token& identifier(const char* what);
  [[noreturn]] void wrong(const Token& at, std::string text);
  std::string found() const;

  std::span<const Token> tokens_;
  size_t at_ = 0;
  uint32_t depth_ = 0;
  bool isInFormals_ = false;  // of a shader: only their lists may be empty
  Pool& pool_;
  Names& names_;
  Messages& messages_;
};

constexpr uint32_t kMostDepth = 200;       // of statements and parentheses inside each other
constexpr uint32_t kMostTreeDepth = 1000;  // of an expression: a sum of so many terms is one

struct Parser::Deeper {
  explicit Deeper(Parser& parser) : parser_(parser) {
    if (++parser.depth_ > kMostDepth)
      parser.messages_.fatal(parser.peek().pos, "the source is nested too deeply here");
  }
  ~Deeper() { --parser_.depth_; }
  Parser& parser_;
};

inline bool isTypeKeyword(Name name) {
  switch (Keyword(name)) {
    case Keyword::k_int:
    case Keyword::k_float:
    case Keyword::k_string:
    case Keyword::k_color:
    case Keyword::k_point:
    case Keyword::k_vector:
    case Keyword::k_normal:
    case Keyword::k_matrix:
    case Keyword::k_void:
    case Keyword::k_closure:
      return true;
    default:
      return false;
  }
}

}  // namespace kinora::language::front
