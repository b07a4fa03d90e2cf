#include <unordered_map>

#include "language/optimise/settings.h"

namespace kinora::language {

struct ConstantPool::Map {
  std::unordered_map<std::string, SymbolId> byText;
};

ConstantPool::ConstantPool(Shader& shader) : shader_(shader), map_(std::make_shared<Map>()) {
  for (size_t i = 0; i < shader.symbols.size(); ++i)
    if (shader.symbols[i].kind == SymbolKind::Constant)
      map_->byText.emplace(keyOf(shader.symbols[i].type, shader.symbols[i].values), SymbolId(i));
}
SymbolId ConstantPool::find(const Type& type, Values values) {
  const auto [at, isNew] = map_->byText.emplace(keyOf(type, values), SymbolId(shader_.symbols.size()));
  if (isNew) {
    Symbol symbol;
    symbol.name = "$const" + std::to_string(shader_.symbols.size());
    symbol.kind = SymbolKind::Constant;
    symbol.type = type;
    symbol.values = std::move(values);
    shader_.symbols.push_back(std::move(symbol));
  }
  return at->second;
}
SymbolId ConstantPool::ofInt(int32_t i) { return find({Base::Int, 0, -1}, {.ints = {i}}); }
SymbolId ConstantPool::ofFloat(float f) { return find({Base::Float, 0, -1}, {.floats = {f}}); }
SymbolId ConstantPool::ofString(const std::string& s) { return find({Base::String, 0, -1}, {.strings = {s}}); }

}  // namespace kinora::language
