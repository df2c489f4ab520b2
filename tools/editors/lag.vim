{% macro either(kind) %}%({{ words(kind)|join('|') }}){% endmacro %}
{% set value = 'lagComment,lagFunction,lagClause,lagStatement,lagConstant,lagIndexed,lagName,lagNumber,lagUnit,lagMember,lagBracket,lagOperator' %}
" Syntax of .lag files. {{ made }}
if exists('b:current_syntax') | finish | endif
syn case match
syn match lagOperator /\v\*\*|\.\.|[-+*\/^=<>:,']/
syn match lagName /\v[[:alpha:]_]\k*|[^\x00-\x7f]\k*/
syn match lagNumber /\v[0-9]+%(\.[0-9]+)?%([eE][+-]?[0-9]+)?/
syn match lagConstant /\v<{{ either('constant') }}>[\[]@!/
syn match lagClause /\v<{{ either('clause') }}>\s*/
syn match lagClause /\v<in\ze\s*[\[(]/ nextgroup=lagBounds skipwhite
syn region lagBounds matchgroup=lagOperator start=/[\[(]/ end=/[\])]/ contained contains={{ value }}
syn match lagStatement /\v<{{ either('statement') }}>\s*/
syn match lagFunction /\v<{{ either('function') }}>\ze\s*\(/
syn match lagMember /\v%(\k|\])@1<=\.{{ either('member') }}>/
syn region lagBracket start=/(/ end=/)/ contains={{ value }}
syn region lagBracket start=/\[/ end=/\]/ contains={{ value }}
syn match lagUnit /\v%(\k|['\])])@1<=\s*\zs\[[^\[\]#]*\]/
syn region lagIndexed matchgroup=lagName start=/\v%([[:alpha:]_]|[^\x00-\x7f])\k*\[/ matchgroup=NONE end=/\]/ contains={{ value }}
syn match lagPart /\v%(^\s*\k+\s+)@<!%(%(\k|['\])])\s+)@<={{ either('part') }}>\s*/ contained
syn match lagShape /\v%(^\s*%(draw|view)\s+)@<={{ either('shape') }}>\s*/ contained
syn match lagFile /\v%(<{{ either('method') }}\s+)@<=[^ \t#]+/ contained
syn match lagTableau /\v%(method\s+\k+\s+)@<={{ either('method') }}>\s*/ contained
syn match lagStatement /\v^\s*\zs{{ either('opening') }}>\s*/
syn match lagStatement /\v%(^\s*)@<={{ either('named') }}>\ze\s+%(\k|")/
syn match lagFile /"[^"]*"/
syn match lagJoining /\v%(\k|")@1<=\s+{{ either('joining') }}>\s*/ contained
syn region lagNamed start=/\v^\s*\zs{{ either('named') }}>\ze\s+%(\k|")/ end=/$/ contains={{ value }},lagFile,lagJoining
syn region lagDrawing start=/\v^\s*\zs%(draw|view)>/ end=/$/ contains={{ value }},lagShape,lagPart
syn region lagBody start=/\v^\s*\zs{{ either('parted') }}>\ze\s+\k/ end=/$/ contains={{ value }},lagPart
syn region lagMethod start=/\v^\s*\zsmethod>/ end=/$/ contains={{ value }},lagTableau,lagFile
syn match lagComment /#.*$/
syn sync minlines=50
hi def link lagComment Comment
hi def link lagStatement Statement
hi def link lagClause Keyword
hi def link lagShape Type
hi def link lagFunction Function
hi def link lagConstant Constant
hi def link lagNumber Number
hi def link lagUnit Type
hi def link lagOperator Operator
hi def link lagMember Identifier
hi def link lagFile String
hi def link lagPart lagClause
hi def link lagTableau lagClause
hi def link lagJoining lagClause
let b:current_syntax = 'lag'
