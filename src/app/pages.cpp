// Writes the manual page, or the completions of a shell, from the table of verbs.
#include "stylet/app/command_line.hpp"

#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace stylet;

using Options = std::vector<const CLI::Option*>;

std::vector<const CLI::App*> verbs_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

Options options_of(const CLI::App& app, bool positional) {
  return app.get_options(
      [=](const CLI::Option* option) { return option->get_positional() == positional; });
}

bool takes_value(const CLI::Option& option) {
  return option.get_items_expected_max() > 0;
}

/// "-h --help"
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const auto& name : option.get_snames()) names.push_back("-" + name);
  for (const auto& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

/// `text` with each of `special` behind `mark`.
std::string escaped(std::string_view text, std::string_view special, std::string_view mark) {
  std::string out;
  for (const char c : text) {
    if (special.find(c) != std::string_view::npos) out += mark;
    out += c;
  }
  return out;
}

// Manual page, in the man macros of troff.

/// A full stop or a quote at the start of a line would be a request.
std::string roff(std::string_view text) {
  std::string out;
  bool line_start = true;
  for (const char c : text) {
    if (line_start && (c == '.' || c == '\'')) out += "\\&";
    line_start = c == '\n';
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if (c == '\'') {
      out += "\\(aq";
    } else if (c == '`') {
      out += "\\(ga";
    } else {
      out += c;
    }
  }
  return out;
}

std::string roff_entry(const CLI::Option& option) {
  std::string text = ".TP\n";
  if (option.get_positional()) {
    text += "\\fI" + roff(upper(option.get_name(true))) + "\\fR";
  } else {
    bool first = true;
    for (const auto& name : names_of(option)) {
      text += (first ? "\\fB" : ", \\fB") + roff(name) + "\\fR";
      first = false;
    }
    if (takes_value(option)) text += " \\fI" + roff(option.get_type_name()) + "\\fR";
  }
  text += "\n" + roff(option.get_description());
  if (!option.get_default_str().empty()) {
    text += " (default: " + roff(option.get_default_str()) + ")";
  }
  return text + "\n";
}

std::string roff_options(const CLI::App& app) {
  std::string text;
  for (const bool positional : {true, false}) {
    for (const CLI::Option* option : options_of(app, positional)) text += roff_entry(*option);
  }
  return text;
}

std::string manual(const CLI::App& app) {
  std::string text = ".TH STYLET 1 \"\" \"stylet " STYLET_VERSION "\" \"User Commands\"\n";
  text += ".SH NAME\nstylet \\- simulate needle insertion into soft tissue\n";
  text += ".SH SYNOPSIS\n";
  for (const CLI::App* verb : verbs_of(app)) {
    text += ".B stylet " + verb->get_name() + "\n";
    for (const CLI::Option* option : options_of(*verb, true)) {
      text += ".I " + roff(upper(option->get_name(true))) + "\n";
    }
    text += "[\\fIOPTION\\fR]... [\\-\\- \\fIPETSC_OPTION\\fR...]\n.br\n";
  }
  text += ".B mpirun \\-n\n.I N\n.B stylet\n\\&...\n";
  text += ".SH DESCRIPTION\n" + roff(app.get_description()) + "\n" + roff(remarks) + "\n";
  text += ".SH OPTIONS\n" + roff_options(app);
  text += ".SH VERBS\n";
  for (const CLI::App* verb : verbs_of(app)) {
    text += ".SS stylet " + verb->get_name() + "\n" + roff(verb->get_description()) + "\n" +
            roff_options(*verb);
  }
  text += ".SH EXIT STATUS\n" + roff(exit_codes) + "\n";
  text += ".SH EXAMPLES\n.nf\n" + roff(examples) + "\n.fi\n";
  return text + ".SH SEE ALSO\n.BR mpirun (1)\n";
}

// Completions.

std::string words_of(const CLI::App& app) {
  std::string words;
  for (const CLI::Option* option : options_of(app, false)) {
    for (const auto& name : names_of(*option)) words += (words.empty() ? "" : " ") + name;
  }
  return words;
}

std::string bash(const CLI::App& app) {
  std::string verbs;
  std::string cases;
  for (const CLI::App* verb : verbs_of(app)) {
    verbs += " " + verb->get_name();
    cases += "    " + verb->get_name() + ") words='" + words_of(*verb) + "' ;;\n";
  }
  return R"(# bash completion of stylet; files where nothing else is meant
_stylet() {
  local current=${COMP_WORDS[COMP_CWORD]} verb= word words=
  COMPREPLY=()
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    [ "$word" != -- ] || return
    [ -n "$verb" ] || [[ $word == -* ]] || verb=$word
  done
  case $verb in
    '') words=')" +
         words_of(app) + verbs + "' ;;\n" + cases + R"(  esac
  [ -n "$verb" ] && [[ $current != -* ]] || mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
}
complete -o default -F _stylet stylet
)";
}

std::string zsh(const CLI::App& app) {
  const auto quoted = [](std::string_view text) {
    std::string out = escaped(text, "\\[]:", "\\");
    for (std::size_t at = 0; (at = out.find('\'', at)) != std::string::npos; at += 4) {
      out.replace(at, 1, "'\\''");
    }
    return out;
  };
  const auto specs = [&](const CLI::App& one) {
    std::string text;
    for (const CLI::Option* option : options_of(one, false)) {
      for (const auto& name : names_of(*option)) {
        text += " \\\n      '*" + name + "[" + quoted(option->get_description()) + "]" +
                (takes_value(*option) ? ":" + option->get_type_name() + ":_files'" : "'");
      }
    }
    return text;
  };
  std::string verbs;
  std::string cases;
  for (const CLI::App* verb : verbs_of(app)) {
    verbs += "    '" + verb->get_name() + ":" + quoted(verb->get_description()) + "'\n";
    cases += "    " + verb->get_name() + ") _arguments" + specs(*verb) + " '*:file:_files' ;;\n";
  }
  return "#compdef stylet\n_stylet() {\n  local -a verbs=(\n" + verbs +
         "  )\n  if (( CURRENT == 2 )); then\n    _describe verb verbs\n    _arguments" +
         specs(app) +
         "\n    return\n  fi\n  local verb=$words[2]\n  shift words\n  (( CURRENT-- ))\n"
         "  case $verb in\n" +
         cases + "  esac\n}\n_stylet \"$@\"\n";
}

std::string fish(const CLI::App& app) {
  const auto quoted = [](std::string_view text) { return "'" + escaped(text, "\\'", "\\") + "'"; };
  std::string text;
  const auto add = [&](const CLI::App& one, const std::string& when) {
    for (const CLI::Option* option : options_of(one, false)) {
      text += "complete -c stylet -n " + quoted(when);
      for (const auto& name : option->get_snames()) text += " -s " + name;
      for (const auto& name : option->get_lnames()) text += " -l " + name;
      text +=
          (takes_value(*option) ? " -r -d " : " -d ") + quoted(option->get_description()) + "\n";
    }
  };
  add(app, "__fish_use_subcommand");
  for (const CLI::App* verb : verbs_of(app)) {
    text += "complete -c stylet -f -n __fish_use_subcommand -a " + verb->get_name() + " -d " +
            quoted(verb->get_description()) + "\n";
    add(*verb, "__fish_seen_subcommand_from " + verb->get_name());
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view wanted = argc == 2 ? argv[1] : "";
  Asked asked;
  CLI::App app;
  declare(app, asked);
  std::string text;
  if (wanted == "man") text = manual(app);
  if (wanted == "bash") text = bash(app);
  if (wanted == "zsh") text = zsh(app);
  if (wanted == "fish") text = fish(app);
  if (text.empty()) {
    std::fputs("usage: stylet_pages man|bash|zsh|fish\n", stderr);
    return 2;
  }
  return std::fputs(text.c_str(), stdout) < 0 || std::fclose(stdout) != 0 ? 4 : 0;
}
