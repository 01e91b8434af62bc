{%- macro options_of(command) -%}
{%- for nested in command.commands %}{{ options_of(nested) }}{% endfor -%}
{%- for option in command.options if option.names %} {{ option.names | join(" ") }}{% endfor -%}
{%- endmacro -%}
{%- macro values_of(command) -%}
{%- for nested in command.commands %} {{ nested.name }}{{ values_of(nested) }}{% endfor -%}
{%- for option in command.options if option.positional -%}
{%- if option["values"] or option.suggested %} {{ (option["values"] + option.suggested) | join(" ") }}{% endif -%}
{%- endfor -%}
{%- endmacro -%}
{%- macro choices_of(command) -%}
{%- for nested in command.commands %}{{ choices_of(nested) }}{% endfor -%}
{%- for option in command.options if not option.positional and (option["values"] or option.suggested) %}
        {{ option.names | join("|") }}) COMPREPLY=($(compgen -W '{{ (option["values"] + option.suggested) | join(" ") }}' -- "$current")); return ;;
{%- endfor -%}
{%- endmacro -%}

# bash completion of cxlab; made by: cxlab completion bash
_cxlab() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} options='--help --version' values
  if [ "$COMP_CWORD" = 1 ]; then
    values='{{ cxlab.commands | map(attribute="name") | join(" ") }}'
  else
  case ${COMP_WORDS[1]} in
{%- for command in cxlab.commands %}
    {{ command.name }})
      options='{{ options_of(command) | trim }}'
      values='{{ values_of(command) | trim }}'
      {%- if choices_of(command) %}
      case $previous in
      {{- choices_of(command) }}
      esac
      {%- endif %}
      ;;
{%- endfor %}
  esac
  fi
  case $current in
    -*) COMPREPLY=($(compgen -W "$options" -- "$current")) ;;
    *) COMPREPLY=($(compgen -W "$values" -- "$current"))
       [ "$COMP_CWORD" = 1 ] || COMPREPLY+=($(compgen -f -- "$current")) ;;
  esac
}
complete -o filenames -F _cxlab cxlab

