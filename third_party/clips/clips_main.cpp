// The command line of CLIPS. The stock main program waits for ever at the end of its input; this one
// carries out what is complete and ends, so that it can stand in a pipe.

#include <clips_ns/clips.h>
#include <ctype.h>
#include <signal.h>

namespace {

clips::Environment* environment = nullptr;

void stop_rules(int) {
  clips::SetHaltExecution(environment, true);
  clips::CloseAllBatchSources(environment);
}

/// Whether the text is only space and comments.
bool is_blank(const char* text) {
  bool in_comment = false;
  for (; *text != '\0'; ++text) {
    if (*text == ';') in_comment = true;
    if (*text == '\n') in_comment = false;
    if (!in_comment && !isspace(static_cast<unsigned char>(*text))) return false;
  }
  return true;
}

/// Takes the next character of the input into the command. A last line without a newline counts as a
/// line; a command that is still incomplete after it ends the program with status 1.
void read_character(clips::Environment* env) {
  static bool at_end = false;
  const int c = clips::ReadRouter(env, clips::STDIN);
  if (c != EOF) {
    at_end = false;
    clips::ExpandCommandString(env, static_cast<char>(c));
    return;
  }
  const char* command = clips::GetCommandString(env);
  const bool command_is_open = command != nullptr && !is_blank(command);
  if (command_is_open && !at_end) {
    at_end = true;
    clips::ExpandCommandString(env, '\n');
    return;
  }
  clips::WriteString(env, clips::STDOUT, "\n");
  if (command_is_open) clips::WriteString(env, clips::STDERR, "The input ends inside a command.\n");
  clips::ExitRouter(env, command_is_open ? 1 : 0);
}

}  // namespace

int main(int argc, char* argv[]) {
  environment = clips::CreateEnvironment();
  signal(SIGINT, stop_rules);
  clips::SetEventFunction(environment, read_character);
  clips::RerouteStdin(environment, argc, argv);
  clips::CommandLoop(environment);
}
