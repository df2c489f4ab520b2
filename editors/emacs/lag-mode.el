;;; lag-mode.el --- Lagrangians for pkgen  -*- lexical-binding: t -*-
;; Made by tools/editors from the words of the language; do not edit.

;; Package-Requires: ((emacs "26.1"))
;; SPDX-License-Identifier: MIT

;;; Commentary:
;; Colours of .lag files; with eglot, all that `pkgen lsp' tells.

;;; Code:

(defun lag--words (&rest words)
  "A pattern of WORDS, the first group being the word."
  (concat "\\_<\\(" (regexp-opt words) "\\)\\_>"))

(defun lag--value-end (start)
  "Whether something complete ends before the blanks before START."
  (save-excursion
    (goto-char start)
    (skip-chars-backward " \t")
    (and (not (bolp)) (looking-back "[])'[:alnum:]_]" (1- (point))))))

(defun lag--part (limit)
  "Find a word that stands behind a value before LIMIT."
  (let (found)
    (while (and (not found) (re-search-forward (lag--words "along" "at" "box" "coord" "cylinder" "delay" "disk" "ellipsoid" "fixed" "free" "friction" "from" "in" "inertia" "lasting" "limits" "mass" "off" "offset" "on" "planar" "poisson" "prismatic" "radius" "restitution" "revolute" "scale" "spherical" "static" "then" "to" "top" "turned" "turns" "width" "with") limit t))
      (setq found (save-match-data
                    (and (zerop (car (save-excursion (syntax-ppss))))
                         (lag--value-end (match-beginning 0))))))
    found))

(defun lag--unit (limit)
  "Find a unit before LIMIT: behind a value, not touching its name."
  (let (found)
    (while (and (not found) (re-search-forward "\\[[^][\n#]*\\]" limit t))
      (let ((start (match-beginning 0)))
        (save-match-data
          (save-excursion
            (goto-char start)
            (let ((blank (< (skip-chars-backward " \t") 0)))
              (setq found
                    (and (lag--value-end start)
                         (not (memq (get-text-property (1- (point)) 'face)
                                    '(font-lock-builtin-face font-lock-keyword-face font-lock-type-face)))
                         (or blank
                             (memq (char-before) '(?\) ?\] ?'))
                             (looking-back "\\_<[0-9][0-9.]*\\(?:[eE][-+]?[0-9]+\\)?"
                                           (line-beginning-position))))))))
        (unless found (goto-char (1+ start)))))
    found))

(defun lag--end ()
  "The end of the statement that begins before point: a line goes on in a bracket."
  (save-excursion
    (end-of-line)
    (while (and (> (car (syntax-ppss)) 0) (not (eobp)))
      (forward-line 1)
      (end-of-line))
    (point)))

(defconst lag-font-lock-keywords
  `(("\\_<method[ \t]+\\sw+[ \t]+\\(tableau\\)[ \t]+\\([^ \t\n#]+\\)"
     (1 'font-lock-builtin-face) (2 'font-lock-string-face))
    (,(concat "^[ \t]*" (lag--words "draw" "view") "\\(?:[ \t]+" (lag--words "arrow" "bob" "body" "circle" "curve" "ground" "level" "line" "plane" "rod" "space" "spring" "trail") "\\)?")
     (1 'font-lock-keyword-face) (2 'font-lock-type-face nil t)
     (lag--part (lag--end) nil (1 'font-lock-builtin-face)))
    (,(concat "^[ \t]*" (lag--words "body" "contact" "event" "friction" "impact" "joint" "mode" "sample") "[ \t]+[[:alpha:]_]")
     (1 'font-lock-keyword-face)
     (lag--part (lag--end) nil (1 'font-lock-builtin-face)))
    ("\"[^\"\n]*\"" (0 'font-lock-string-face))
    (,(concat "^[ \t]*" (lag--words "contact" "exact" "friction" "impact" "memory" "mode" "noise" "sample" "table" "use") "[ \t]+[\"[:alpha:]_]")
     (1 'font-lock-keyword-face)
     (,(lag--words "as" "with") (lag--end) nil (1 'font-lock-builtin-face)))
    (,(concat "^[ \t]*" (lag--words "body" "draw" "fast" "gravity" "hamiltonian" "joint" "torque" "view")) (1 'font-lock-keyword-face))
    (,(concat (lag--words "abs" "acos" "am" "asin" "atan" "atan2" "ceil" "clamp" "cn" "cos" "cosh" "cross" "dn" "dot" "drift" "ellipk" "error" "euler" "exp" "floor" "if" "integral" "inverse" "kepler" "ln" "log" "loss" "max" "min" "mod" "norm" "omega" "power" "rot" "round" "sign" "sin" "sinh" "sn" "sqrt" "step" "sum" "tait_bryan" "tan" "tanh" "time") "[ \t]*(") (1 'font-lock-function-name-face))
    (,(lag--words "accuracy" "conserve" "const" "constraint" "coord" "dissipation" "end" "event" "expect" "fixed" "force" "free" "hold" "input" "kinetic" "lagrangian" "let" "method" "model" "observe" "param" "periodic" "potential" "rate" "record" "rolling" "rotation" "scene" "set" "size" "start" "state" "swarm" "until") (1 'font-lock-keyword-face))
    (,(lag--words "and" "at" "either" "every" "falling" "in" "not" "or" "rising" "rtol" "step" "stop" "while" "within") (1 'font-lock-builtin-face))
    (,(lag--words "energy" "inf" "pi" "t") (1 'font-lock-constant-face))
    (lag--unit (0 'font-lock-type-face)))
  "What is coloured in a .lag file.")

(defvar lag-mode-syntax-table
  (let ((table (make-syntax-table)))
    (modify-syntax-entry ?# "<" table)
    (modify-syntax-entry ?\n ">" table)
    (modify-syntax-entry ?_ "_" table)
    (dolist (sign '(?' ?\" ?. ?+ ?- ?* ?/ ?^ ?= ?< ?> ?& ?| ?%))
      (modify-syntax-entry sign "." table))
    table)
  "The syntax of .lag files.")

;;;###autoload
(define-derived-mode lag-mode prog-mode "Lag"
  "A mode for Lagrangians of pkgen."
  (setq-local comment-start "# ")
  (setq-local comment-end "")
  (setq-local font-lock-multiline t)
  (setq-local font-lock-defaults '(lag-font-lock-keywords)))

;;;###autoload
(add-to-list 'auto-mode-alist '("\\.lag\\'" . lag-mode))

(defvar eglot-server-programs)
(with-eval-after-load 'eglot
  (add-to-list 'eglot-server-programs '(lag-mode . ("pkgen" "lsp"))))

(provide 'lag-mode)
;;; lag-mode.el ends here
