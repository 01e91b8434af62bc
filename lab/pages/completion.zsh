{%- macro quoted(text) -%} '{{ text | replace("'", "'\\''") }}' {%- endmacro -%}
{%- macro zsh(text) -%}
{{ text | replace("\\", "\\\\") | replace("[", "\\[") | replace("]", "\\]") | replace(":", "\\:") | replace("\n", " ") }}
{%- endmacro -%}

#compdef cxlab
# zsh completion of cxlab; made by: cxlab completion zsh
{%- for command in cxlab.commands %}
{%- for option in command.options if option.positional and option.suggested and option.files %}
_cxlab_{{ command.name }}() { _alternative {{ quoted("names:name:(" ~ (option.suggested | join(" ")) ~ ")") }} 'files:file:_files' }
{%- endfor %}
{%- endfor %}
_cxlab() {
  local -a commands
  commands=(
{%- for command in cxlab.commands %}
    {{ quoted(command.name ~ ":" ~ zsh(command.description)) }}
{%- endfor %}
  )
  if (( CURRENT == 2 )); then
    _describe command commands
    return
  fi
  local command=$words[2]
  shift words
  (( CURRENT-- ))
  case $command in
{%- for command in cxlab.commands %}
    {{ command.name }}) _arguments
    {%- for part in [command] + command.commands -%}
      {%- for option in part.options -%}
        {%- for name in option.names -%}
          {%- set known = option["values"] + option.suggested -%}
          {%- set value = "" if not option.takes_value else ":value:(" ~ (known | join(" ")) ~ ")" if known else ":value:_files" %} \
      {{ quoted(("*" if option.many else "") ~ name ~ "[" ~ zsh(option.description) ~ "]" ~ value) }}
        {%- endfor -%}
      {%- endfor -%}
    {%- endfor %} \
    {%- set files -%}
      {%- for option in command.options if option.positional and option.suggested and option.files -%}_cxlab_{{ command.name }}{%- endfor -%}
    {%- endset -%}
    {%- set values -%}
      {%- for part in [command] + command.commands -%}
        {%- if not loop.first %} {{ part.name }}{% endif -%}
        {%- for option in part.options if option.positional and (option["values"] or option.suggested) %} {{ (option["values"] + option.suggested) | join(" ") }}{% endfor -%}
      {%- endfor -%}
    {%- endset %}
      {{ quoted("*:argument:" ~ (files if files else "(" ~ (values | trim) ~ ")" if values else "_files")) }} ;;
{%- endfor %}
  esac
}
if [ "$funcstack[1]" = _cxlab ]; then _cxlab "$@"; else compdef _cxlab cxlab; fi

