// setmessage and getmessage within a group become plain code.
#include <algorithm>
#include <unordered_map>

#include "language/optimise/instruction.h"
#include "language/optimise/optimise.h"

namespace kinora::language {

namespace {

// A message is its content, for each type that sets it, and what is known of it: state (1 set, 2 asked for in vain),
// type, place and layer. Setting it again, or after it was missed, or asking for another type or from a layer before
// the one that set it is an error and does nothing.
class MessageLinker {
 public:
  explicit MessageLinker(FlatProgram& flat) : shader_(flat.code), pool_(flat.code) {}
  void run() { link(shader_.main); }

 private:
  struct Message {
    SymbolId state = kNone, type = kNone, where = kNone, layer = kNone;
    std::unordered_map<std::string, SymbolId> contents;  // by type
  };
  SymbolId messageSymbol(const std::string& name, const Type& type) {
    Symbol made;
    made.name = name;
    made.type = type;
    shader_.symbols.push_back(std::move(made));
    return SymbolId(shader_.symbols.size() - 1);
  }
  Message& messageNamed(const std::string& name) {
    Message& m = messages_[name];
    if (m.state == kNone) {
      m.state = messageSymbol("$message." + name + ".state", {Base::Int, 0, -1});
      m.type = messageSymbol("$message." + name + ".type", {Base::String, 0, -1});
      m.where = messageSymbol("$message." + name + ".where", {Base::String, 0, -1});
      m.layer = messageSymbol("$message." + name + ".layer", {Base::Int, 0, -1});
    }
    return m;
  }
  SymbolId text(const std::string& s) { return pool_.ofString(s); }
  SymbolId temporary() {
    const SymbolId id = messageSymbol("$free" + std::to_string(shader_.symbols.size()), {Base::Int, 0, -1});
    shader_.symbols[size_t(id)].kind = SymbolKind::Temp;
    return id;
  }
  void link(Block& block) {
    for (size_t at = 0; at < block.code.size(); ++at) {
      for (Block& inner : block.code[at].blocks) link(inner);
      const Instruction in = block.code[at];
      const bool sets = in.opcode == Opcode::SetMessage;
      if (!(sets && in.arguments.size() == 2) && !(in.opcode == Opcode::GetMessage && in.arguments.size() == 3))
        continue;
      const SymbolId nameId = in.arguments[sets ? 0 : 1];
      const Symbol nameSymbol = shader_.symbols[size_t(nameId)];
      if (nameSymbol.kind != SymbolKind::Constant || nameSymbol.values.strings.size() != 1) continue;
      const std::string name = nameSymbol.values.strings[0];
      const SymbolId value = in.arguments[sets ? 1 : 2];
      const Type type = shader_.symbols[size_t(value)].type;
      Message& m = messageNamed(name);
      const auto [found, isNew] = m.contents.emplace(nameOf(type), kNone);
      if (isNew) found->second = messageSymbol("$message." + name, type);
      const SymbolId content = found->second, here = text(in.pos.str()), typeText = text(nameOf(type));
      const Opcode copy = type.arrayLength ? Opcode::ArrayCopy : Opcode::Assign;
      std::vector<Instruction> made;
      const auto emit = [&](std::vector<Instruction>& to, Opcode op, std::vector<SymbolId> arguments) {
        to.push_back(makeInstruction(op, std::move(arguments), in.layer));
        to.back().pos = in.pos;
      };
      const auto branch = [&](std::vector<Instruction>& to, SymbolId condition) -> Instruction& {
        to.push_back(makeInstruction(Opcode::If, {condition}, in.layer));
        to.back().blocks.resize(2);
        return to.back();
      };
      const SymbolId isFree = temporary();
      if (sets) {
        emit(made, Opcode::Eq, {isFree, m.state, pool_.ofInt(0)});
        const SymbolId isSet = temporary();
        Instruction& free = branch(made, isFree);
        emit(free.blocks[0].code, copy, {content, value});
        emit(free.blocks[0].code, Opcode::Assign, {m.state, pool_.ofInt(1)});
        emit(free.blocks[0].code, Opcode::Assign, {m.type, typeText});
        emit(free.blocks[0].code, Opcode::Assign, {m.where, here});
        emit(free.blocks[0].code, Opcode::Assign, {m.layer, pool_.ofInt(in.layer)});
        std::vector<Instruction>& other = free.blocks[1].code;
        emit(other, Opcode::Eq, {isSet, m.state, pool_.ofInt(1)});
        Instruction& again = branch(other, isSet);
        emit(again.blocks[0].code, Opcode::Complain,
             {text("message \"%s\" already exists (created here: %s) cannot set again from %s"), nameId, m.where,
              here});
        emit(again.blocks[1].code, Opcode::Complain,
             {text("message \"%s\" was queried before being set (queried here: %s) setting it now (%s) would lead to "
                   "inconsistent results"),
              nameId, m.where, here});
      } else {
        // found when it is set, of this type, by no later layer
        const SymbolId isAlike = temporary(), isBefore = temporary(), isSet = temporary();
        emit(made, Opcode::Assign, {in.arguments[0], pool_.ofInt(0)});
        emit(made, Opcode::Eq, {isSet, m.state, pool_.ofInt(1)});
        Instruction& set = branch(made, isSet);
        std::vector<Instruction>& there = set.blocks[0].code;
        emit(there, Opcode::Eq, {isAlike, m.type, typeText});
        Instruction& alike = branch(there, isAlike);
        std::vector<Instruction>& fits = alike.blocks[0].code;
        emit(fits, Opcode::Le, {isBefore, m.layer, pool_.ofInt(in.layer)});
        Instruction& before = branch(fits, isBefore);
        emit(before.blocks[0].code, copy, {value, content});
        emit(before.blocks[0].code, Opcode::Assign, {in.arguments[0], pool_.ofInt(1)});
        emit(before.blocks[1].code, Opcode::Complain,
             {text("message \"%s\" was set by layer #%d (%s) but is being queried by layer #%d (%s) - messages may "
                   "only be transferred from nodes that appear earlier in the shading network"),
              nameId, m.layer, m.where, pool_.ofInt(in.layer), here});
        emit(alike.blocks[1].code, Opcode::Complain,
             {text("type mismatch for message \"%s\" (created as %s here: %s) cannot fetch as %s from %s"), nameId,
              m.type, m.where, typeText, here});
        std::vector<Instruction>& missed = set.blocks[1].code;
        emit(missed, Opcode::Eq, {isFree, m.state, pool_.ofInt(0)});
        Instruction& first = branch(missed, isFree);
        emit(first.blocks[0].code, Opcode::Assign, {m.state, pool_.ofInt(2)});
        emit(first.blocks[0].code, Opcode::Assign, {m.where, here});
      }
      block.code.erase(block.code.begin() + std::ptrdiff_t(at));
      block.code.insert(block.code.begin() + std::ptrdiff_t(at), std::make_move_iterator(made.begin()),
                        std::make_move_iterator(made.end()));
      at += made.size() - 1;
    }
  }

  Shader& shader_;
  ConstantPool pool_;
  std::unordered_map<std::string, Message> messages_;  // by name
};

}  // namespace

void linkMessages(FlatProgram& flat) { MessageLinker(flat).run(); }

}  // namespace kinora::language
