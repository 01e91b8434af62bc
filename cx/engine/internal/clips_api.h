#pragma once
// CLIPS for our own sources, and the parts of its interface that clips.h leaves out.

#include <clips_ns/clips.h>

namespace clips {
extern "C" {
// tmpltutl.h: the deftemplate of ordered facts `(name ...)`, made when there is none.
Deftemplate* CreateImpliedDeftemplate(Environment*, CLIPSLexeme*, bool);
}

// The data of CLIPS behind its functions. Its macros cast in the style of C, so that each is used once, here.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
inline void* environment_data(Environment* env, unsigned position) { return GetEnvironmentData(env, position); }
inline agendaData* agenda_data(Environment* env) { return AgendaData(env); }
inline commandLineData* command_line_data(Environment* env) { return CommandLineData(env); }
inline constructData* construct_data(Environment* env) { return ConstructData(env); }
inline defruleData* defrule_data(Environment* env) { return DefruleData(env); }
inline engineData* engine_data(Environment* env) { return EngineData(env); }
inline evaluationData* evaluation_data(Environment* env) { return EvaluationData(env); }
inline externalFunctionData* external_function_data(Environment* env) { return ExternalFunctionData(env); }
inline expressionData* expression_data(Environment* env) { return ExpressionData(env); }
inline factsData* fact_data(Environment* env) { return FactData(env); }
inline fileRouterData* file_router_data(Environment* env) { return FileRouterData(env); }
inline memoryData* memory_data(Environment* env) { return MemoryData(env); }
inline patternData* pattern_data(Environment* env) { return PatternData(env); }
inline routerData* router_data(Environment* env) { return RouterData(env); }
inline utilityData* utility_data(Environment* env) { return UtilityData(env); }
#pragma GCC diagnostic pop
}  // namespace clips
