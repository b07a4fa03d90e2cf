// The source as a tree. The parser makes it, the checker writes types and what names mean into it, lowering walks it
// (a function once for each call). Everything lives in the compilation's Pool.
#pragma once
#include <span>
#include <string_view>

#include "language/front/token.h"
#include "language/program/program.h"

namespace kinora::language::front {

struct Expr;
struct Stmt;
struct Var;
struct Function;
struct Builtin;
struct Signature;

struct TypeSpec {  // as written; the checker makes a Type of it
  Base base = Base::Void;
  Name structName = 0;
  bool isUnsized = false;
  Expr* length = nullptr;  // of an array
  Pos pos;
};

enum class ExprKind : uint8_t {
  Bad,
  Int,
  Float,
  String,
  Variable,
  Index,
  Field,
  Unary,
  Binary,
  Assign,
  Increment,
  Ternary,
  Cast,
  Construct,
  Call,
  List,
  Comma
};

struct Expr {
  ExprKind kind = ExprKind::Bad;
  Punct op = Punct::None;  // Unary, Binary, Assign, Increment. && and || are Binary
  bool isPrefix = false;   // Increment
  bool isParenthesised = false;
  uint16_t depth = 1;  // of the tree below
  Pos pos;
  int32_t intValue = 0;
  float floatValue = 0;
  std::string_view text;  // String: the value
  Name name = 0;          // Variable, Field, Call
  TypeSpec spec;          // Cast, Construct
  Expr *a = nullptr, *b = nullptr, *c = nullptr;
  std::span<Expr*> list;  // Call, Construct: arguments; List, Comma: elements
  // from the checker
  Type type;
  Var* var = nullptr;                    // Variable
  Function* function = nullptr;          // Call; Unary, Binary: an overloaded operator
  const Builtin* builtin = nullptr;      // Call
  const Signature* signature = nullptr;  // of the builtin
  int32_t field = -1;                    // Field: of a structure; component of a triple
  bool isStructConstruct = false;        // Call: S(a, b)
  bool isChecked = false;                // before what it is an element of: not again
};

struct MetaDecl {
  TypeSpec spec;
  Name name = 0;
  Pos pos;
  Expr* value = nullptr;
};

enum class VarKind : uint8_t { Parameter, OutputParameter, Argument, OutputArgument, Local, Global };

struct Var {
  Name name = 0;
  Pos pos;
  TypeSpec spec;
  Expr* init = nullptr;
  std::span<MetaDecl> metadata;
  bool isOutput = false;
  // from the checker
  Type type;
  VarKind kind = VarKind::Local;
  bool isWritten = false;
  uint32_t globalIndex = 0;
  // while lowering: the symbol that it is, in the call being lowered
  SymbolId id = kNone;
};

struct StructDecl {
  Name name = 0;
  Pos pos;
  std::span<Var*> fields;
};

enum class StmtKind : uint8_t {
  Empty,
  Expression,
  Block,
  Variables,
  If,
  While,
  DoWhile,
  For,
  Break,
  Continue,
  Return,
  Function,
  Struct
};

struct Stmt {
  StmtKind kind = StmtKind::Empty;
  Pos pos;
  Expr* expr = nullptr;  // condition, value, expression
  Expr* step = nullptr;
  Stmt *init = nullptr, *body = nullptr, *other = nullptr;
  std::span<Stmt*> list;
  std::span<Var*> vars;
  Function* function = nullptr;
  StructDecl* structure = nullptr;
};

struct Function {
  Name name = 0;
  Pos pos;
  TypeSpec spec;
  std::span<Var*> parameters;
  std::span<MetaDecl> metadata;
  Stmt* body = nullptr;  // null: declared only
  // from the checker
  Type type;
  bool isPrelude = false;
  bool isClosure = false;    // declared only, of type closure color: a closure that the renderer may know
  Function* next = nullptr;  // declared earlier by the same name, in this scope or around it
  Function* definition = nullptr;
  uint32_t scope = 0;
  // while lowering
  bool isActive = false;
  int8_t early = -1;  // a return leaves before the end; -1: not looked yet
};

struct ShaderDecl {
  ShaderKind kind = ShaderKind::Shader;
  Name name = 0;
  Pos pos;
  std::span<Var*> parameters;
  std::span<MetaDecl> metadata;
  Stmt* body = nullptr;
};

struct Program {
  struct Item {  // one of the three
    Function* function = nullptr;
    StructDecl* structure = nullptr;
    ShaderDecl* shader = nullptr;
  };
  std::vector<Item> items;
};

}  // namespace kinora::language::front
