#include "language/optimise/liveness.h"

namespace kinora::language {

void Liveness::go(const Block& block, SymbolSet& live, const Targets& targets) {
  for (auto in = block.code.rbegin(); in != block.code.rend(); ++in) step(*in, live, targets);
}

void Liveness::step(const Instruction& in, SymbolSet& live, const Targets& targets) {
  switch (in.opcode) {
    case Opcode::If: {
      SymbolSet other = live;
      if (in.blocks.size() > 1) go(in.blocks[1], other, targets);
      if (in.blocks.size() > 1 && atEntry) atEntry(&in.blocks[1], other);
      go(in.blocks[0], live, targets);
      if (atEntry) atEntry(&in.blocks[0], live);
      live.unite(other);
      live.add(in.arguments[0]);
      return;
    }
    case Opcode::For:
    case Opcode::While:
    case Opcode::DoWhile: {
      const SymbolSet after = live;
      // sets only grow from one turn of an outer loop to the next: what was found before is where to go on from, or
      // loops inside each other would cost twice as much with each level
      SymbolSet& known = heads_.try_emplace(&in, after).first->second;
      known.unite(after);
      SymbolSet head(known), body(after);
      for (bool changed = true; changed;) {
        const SymbolSet before = head;
        SymbolSet turn = head;
        Targets inside = targets;
        inside.onBreak = &after;
        SymbolSet next = head;
        if (in.opcode == Opcode::DoWhile) {
          next.unite(after);
          next.add(in.arguments[0]);
          go(in.blocks[1], next, targets);
          go(in.blocks[3], next, inside);
          inside.onContinue = &next;
          body = next;
          go(in.blocks[2], body, inside);
          turn = body;
        } else {
          go(in.blocks[3], next, inside);
          inside.onContinue = &next;
          body = next;
          go(in.blocks[2], body, inside);
          turn = body;
          turn.unite(after);
          turn.add(in.arguments[0]);
          go(in.blocks[1], turn, targets);
        }
        turn.unite(before);
        changed = !(turn == before);
        head = turn;
      }
      heads_.at(&in) = head;
      if (atEntry) {
        atEntry(&in.blocks[2], body);
        atEntry(&in, head);
      }
      live = head;
      go(in.blocks[0], live, targets);
      return;
    }
    case Opcode::Call: {
      const SymbolSet after = live;
      Targets inside = targets;
      inside.onReturn = &after;
      if (in.arguments.size() == 2) inside.onExit = &after;
      go(in.blocks[0], live, inside);
      if (atEntry) atEntry(&in.blocks[0], live);
      return;
    }
    case Opcode::Break:
      if (targets.onBreak) live = *targets.onBreak;
      return;
    case Opcode::Continue:
      if (targets.onContinue) live = *targets.onContinue;
      return;
    case Opcode::Return:
      if (targets.onReturn) live = *targets.onReturn;
      return;
    case Opcode::Exit:
      if (targets.onExit) live = *targets.onExit;
      return;
    default:
      break;
  }
  if (isDead && isDead(in, live)) return;
  for (uint32_t i = 0; i < in.arguments.size(); ++i)
    if (accessOf(shader_, in, i) == 'w') live.remove(in.arguments[i]);
  for (uint32_t i = 0; i < in.arguments.size(); ++i)
    if (accessOf(shader_, in, i) != 'w') live.add(in.arguments[i]);
}

}  // namespace kinora::language
