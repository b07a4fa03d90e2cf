// One name for each value: a local variable that is written several times in one block of code and read nowhere else
// becomes as many variables, so that later passes see which write a read means.
#include <algorithm>

#include "language/optimise/optimise.h"
#include "language/optimise/walk.h"

namespace kinora::language {

namespace {

class Renaming {
 public:
  explicit Renaming(FlatProgram& flat) : shader_(flat.code), facts_(flat.code.symbols.size()) {
    for (size_t s = 0; s < facts_.size(); ++s) {
      const Symbol& symbol = shader_.symbols[s];
      facts_[s].isOut = (symbol.kind != SymbolKind::Local && symbol.kind != SymbolKind::Temp) ||
                        symbol.type.arrayLength != 0 || componentsOf(symbol.type.base) == 0;
    }
    for (const Output& o : flat.outputs) facts_[size_t(o.symbol)].isOut = true;
    for (const Input& i : flat.inputs) facts_[size_t(i.symbol)].isOut = true;
    look(shader_.main);
    rename(shader_.main);
  }

 private:
  struct Facts {
    bool isOut = false;            // it stays as it is
    const Block* block = nullptr;  // the one that it is used in
    uint32_t writes = 0;
    SymbolId now = kNone;  // the name of the last value written
  };

  void look(const Block& block) {
    for (const Instruction& in : block.code) {
      for (uint32_t k = 0; k < in.arguments.size(); ++k) {
        if (in.arguments[k] < 0) continue;
        Facts& f = facts_[size_t(in.arguments[k])];
        const char access = accessOf(shader_, in, k);
        if (f.block && f.block != &block) f.isOut = true;
        if (!f.block && (access != 'w' || std::count(in.arguments.begin(), in.arguments.end(), in.arguments[k]) > 1))
          f.isOut = true;
        f.block = &block;
        if (access == 'w') ++f.writes;
      }
      for (const Block& inner : in.blocks) look(inner);
    }
  }

  void rename(Block& block) {
    for (Instruction& in : block.code) {
      const std::vector<SymbolId> before = in.arguments;
      const auto isRenamed = [&](SymbolId s) {
        return s >= 0 && !facts_[size_t(s)].isOut && facts_[size_t(s)].writes > 1;
      };
      std::string accesses;
      for (uint32_t k = 0; k < before.size(); ++k) accesses += accessOf(shader_, in, k);
      for (uint32_t k = 0; k < before.size(); ++k)
        if (isRenamed(before[k]) && accesses[k] != 'w') in.arguments[k] = facts_[size_t(before[k])].now;
      for (uint32_t k = 0; k < before.size(); ++k) {
        if (!isRenamed(before[k]) || accesses[k] != 'w') continue;
        SymbolId& now = facts_[size_t(before[k])].now;
        if (now == kNone) {
          now = before[k];
        } else {
          Symbol again = shader_.symbols[size_t(before[k])];
          again.name += "'";
          now = SymbolId(shader_.symbols.size());
          shader_.symbols.push_back(std::move(again));
        }
        in.arguments[k] = now;
      }
      for (Block& inner : in.blocks) rename(inner);
    }
  }

  Shader& shader_;
  std::vector<Facts> facts_;
};

}  // namespace

void renameValues(FlatProgram& flat) { Renaming{flat}; }

}  // namespace kinora::language
