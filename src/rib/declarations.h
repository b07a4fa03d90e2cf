// What a parameter token means: predeclared names, Declare, and inline declarations ("uniform color[3] x"). Used by
// the interpreter. It holds types, never values.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "scene/parameters.h"

namespace kinora::rib {

struct Declaration {
  std::string name;
  scene::StorageClass storage = scene::StorageClass::Uniform;
  scene::ValueType type = scene::ValueType::Float;
  bool hasStorage = false;  // a class was written
  bool isReference = false;
  bool isArray = false;
  int arrayLength = 1;  // 0, written type[] or type[0]: as many as it is given
};

class Declarations {
 public:
  Declarations();
  // "[class] [reference] type[n]" for Declare, n optional; false when it is not one.
  bool declare(const std::string& name, std::string_view declaration);
  // A token of a parameter list: inline, declared or predeclared; null when nothing says its type.
  const Declaration* find(const std::string& token);
  // "[class] [reference] type[n] name". Empty when the text is not a declaration.
  static std::optional<Declaration> parse(std::string_view text, bool withName);

 private:
  std::unordered_map<std::string, Declaration> byName_;
  std::unordered_map<std::string, Declaration> inline_;  // tokens already parsed; bounded
};

}  // namespace kinora::rib
