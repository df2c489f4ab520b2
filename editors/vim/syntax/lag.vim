" Syntax of .lag files. Made by tools/editors from the words of the language; do not edit.
if exists('b:current_syntax') | finish | endif
syn case match
syn match lagOperator /\v\*\*|\.\.|[-+*\/^=<>:,']/
syn match lagName /\v[[:alpha:]_]\k*|[^\x00-\x7f]\k*/
syn match lagNumber /\v[0-9]+%(\.[0-9]+)?%([eE][+-]?[0-9]+)?/
syn match lagConstant /\v<%(energy|inf|pi|t)>[\[]@!/
syn match lagClause /\v<%(and|at|either|every|falling|in|not|or|rising|rtol|step|stop|while|within)>\s*/
syn match lagClause /\v<in\ze\s*[\[(]/ nextgroup=lagBounds skipwhite
syn region lagBounds matchgroup=lagOperator start=/[\[(]/ end=/[\])]/ contained contains=lagComment,lagFunction,lagClause,lagStatement,lagConstant,lagIndexed,lagName,lagNumber,lagUnit,lagMember,lagBracket,lagOperator
syn match lagStatement /\v<%(accuracy|conserve|const|constraint|coord|dissipation|end|event|expect|fixed|force|free|hold|input|kinetic|lagrangian|let|method|model|observe|param|periodic|potential|rate|record|rolling|rotation|scene|set|size|start|state|swarm|until)>\s*/
syn match lagFunction /\v<%(abs|acos|am|asin|atan|atan2|ceil|clamp|cn|cos|cosh|cross|dn|dot|drift|ellipk|error|euler|exp|floor|if|integral|inverse|kepler|ln|log|loss|max|min|mod|norm|omega|power|rot|round|sign|sin|sinh|sn|sqrt|step|sum|tait_bryan|tan|tanh|time)>\ze\s*\(/
syn match lagMember /\v%(\k|\])@1<=\.%(R|com|mass|omega|origin|point|w|x|y|z)>/
syn region lagBracket start=/(/ end=/)/ contains=lagComment,lagFunction,lagClause,lagStatement,lagConstant,lagIndexed,lagName,lagNumber,lagUnit,lagMember,lagBracket,lagOperator
syn region lagBracket start=/\[/ end=/\]/ contains=lagComment,lagFunction,lagClause,lagStatement,lagConstant,lagIndexed,lagName,lagNumber,lagUnit,lagMember,lagBracket,lagOperator
syn match lagUnit /\v%(\k|['\])])@1<=\s*\zs\[[^\[\]#]*\]/
syn region lagIndexed matchgroup=lagName start=/\v%([[:alpha:]_]|[^\x00-\x7f])\k*\[/ matchgroup=NONE end=/\]/ contains=lagComment,lagFunction,lagClause,lagStatement,lagConstant,lagIndexed,lagName,lagNumber,lagUnit,lagMember,lagBracket,lagOperator
syn match lagPart /\v%(^\s*\k+\s+)@<!%(%(\k|['\])])\s+)@<=%(along|at|box|coord|cylinder|delay|disk|ellipsoid|fixed|free|friction|from|in|inertia|lasting|limits|mass|off|offset|on|planar|poisson|prismatic|radius|restitution|revolute|scale|spherical|static|then|to|top|turned|turns|width|with)>\s*/ contained
syn match lagShape /\v%(^\s*%(draw|view)\s+)@<=%(arrow|bob|body|circle|curve|ground|level|line|plane|rod|space|spring|trail)>\s*/ contained
syn match lagFile /\v%(<%(tableau)\s+)@<=[^ \t#]+/ contained
syn match lagTableau /\v%(method\s+\k+\s+)@<=%(tableau)>\s*/ contained
syn match lagStatement /\v^\s*\zs%(body|draw|fast|gravity|hamiltonian|joint|torque|view)>\s*/
syn match lagStatement /\v%(^\s*)@<=%(contact|exact|friction|impact|memory|mode|noise|sample|table|use)>\ze\s+%(\k|")/
syn match lagFile /"[^"]*"/
syn match lagJoining /\v%(\k|")@1<=\s+%(as|with)>\s*/ contained
syn region lagNamed start=/\v^\s*\zs%(contact|exact|friction|impact|memory|mode|noise|sample|table|use)>\ze\s+%(\k|")/ end=/$/ contains=lagComment,lagFunction,lagClause,lagStatement,lagConstant,lagIndexed,lagName,lagNumber,lagUnit,lagMember,lagBracket,lagOperator,lagFile,lagJoining
syn region lagDrawing start=/\v^\s*\zs%(draw|view)>/ end=/$/ contains=lagComment,lagFunction,lagClause,lagStatement,lagConstant,lagIndexed,lagName,lagNumber,lagUnit,lagMember,lagBracket,lagOperator,lagShape,lagPart
syn region lagBody start=/\v^\s*\zs%(body|contact|event|friction|impact|joint|mode|sample)>\ze\s+\k/ end=/$/ contains=lagComment,lagFunction,lagClause,lagStatement,lagConstant,lagIndexed,lagName,lagNumber,lagUnit,lagMember,lagBracket,lagOperator,lagPart
syn region lagMethod start=/\v^\s*\zsmethod>/ end=/$/ contains=lagComment,lagFunction,lagClause,lagStatement,lagConstant,lagIndexed,lagName,lagNumber,lagUnit,lagMember,lagBracket,lagOperator,lagTableau,lagFile
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
